import { render, screen, waitFor, within } from '@testing-library/react';
import userEvent from '@testing-library/user-event';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';

import type { Action, Done } from '../src/model/types';
import { EditorPage } from '../src/shell/EditorPage';
import { TextsContext } from '../src/texts';
import { en } from '../src/texts/en';
import { component, picture, port, wire } from './records';

/** A server in the page's own process: one picture, and answers that the test looks at afterwards. */
function serve(isReadOnly = false) {
  const sensor = component('Sensor0', { ports: [port('out', 'out'), port('raw', 'out', 'TimedOctet')], sets: { default: { gain: '1' } }, constraints: { gain: '0<=x<=5' } });
  const motor = component('Motor0', { ports: [port('speed', 'in')] });
  const one = picture({ read_only: isReadOnly, components: [sensor, motor, component('Camera0')], connectors: [wire('w', 'Sensor0.raw', 'Motor0.speed')] });
  const done: { actions: Action[]; dry_run: boolean }[] = [];
  const answers: Record<string, (body: string) => unknown> = {
    '/api/layout': () => ({ revision: 1, width: 10, height: 10, boxes: {}, paths: {} }),
    '/api/events?since=0': () => ({ events: [] }),
    '/api/connectable?port=%2Flocalhost%2FSensor0.rtc%3Aout': () => ({
      ports: [{ path: `${motor.id}:speed`, type: 'TimedLong', why: '' }, { path: `${sensor.id}:raw`, type: 'TimedOctet', why: 'Both are out ports.' }],
    }),
    '/api/do': (body) => {
      const asked = JSON.parse(body) as { actions: Action[]; dry_run: boolean };
      done.push(asked);
      const steps = asked.actions.map(({ do: verb }) => ({ text: verb, command: `rt ${verb}`, ok: asked.dry_run ? null : true, error: '' }));
      const undo: Action[] = asked.actions[0]?.do === 'connect' ? [{ do: 'disconnect', connector: 'new' }] : [{ do: 'connect', source: 'a:b', target: 'c:d' }];
      return { steps, undo, undo_reason: '' } satisfies Done;
    },
  };
  vi.stubGlobal('fetch', vi.fn((path: string, init: RequestInit) => {
    if (!path.startsWith('/api/stream')) return Promise.resolve(Response.json(answers[path]?.(typeof init.body === 'string' ? init.body : '')));
    const text = `event: picture\ndata: ${JSON.stringify(one)}\n\n`;
    return Promise.resolve(new Response(new ReadableStream({ start: (stream) => stream.enqueue(new TextEncoder().encode(text)) })));
  }));
  return done;
}

async function openPage() {
  const user = userEvent.setup();
  const settings = { theme: 'auto', setTheme: () => undefined, language: 'en', setLanguage: () => undefined } as const;
  render(<TextsContext value={en}><EditorPage token="t" settings={settings} onDenied={() => undefined} /></TextsContext>);
  const row = await screen.findByRole('treeitem', { name: /Sensor0/ });
  return { user, row };
}

beforeEach(() => {
  class NoObserver {
    observe = () => undefined;
    unobserve = () => undefined;
    disconnect = () => undefined;
  }
  vi.stubGlobal('ResizeObserver', NoObserver);
});
afterEach(() => void vi.unstubAllGlobals());

describe('the editor by keyboard', () => {
  it('connects two ports, undoes it and redoes it', async () => {
    const done = serve();
    const { user, row } = await openPage();
    row.focus();
    await user.keyboard('{Enter}c');
    const dialog = await screen.findByRole('dialog', { name: en.connect.title });
    const far = await within(dialog).findByRole('radio', { name: /Motor0:speed/ });
    expect(within(dialog).getByText('Both are out ports.')).toBeTruthy();
    far.focus();
    await user.keyboard(' {Enter}');
    const connect = { do: 'connect', id: expect.any(String) as string, source: '/localhost/Sensor0.rtc:out', target: '/localhost/Motor0.rtc:speed', properties: {} };
    await waitFor(() => expect(done).toEqual([{ actions: [connect], dry_run: true }, { actions: [connect], dry_run: false }]));

    await screen.findByText('rt connect');
    await user.keyboard('{Control>}z{/Control}');
    await waitFor(() => expect(done.at(-1)).toEqual({ actions: [{ do: 'disconnect', connector: 'new' }], dry_run: false }));
    await screen.findByText('rt disconnect');
    await user.keyboard('{Control>}{Shift>}z{/Shift}{/Control}');
    await waitFor(() => expect(done.at(-1)).toEqual({ actions: [{ do: 'connect', source: 'a:b', target: 'c:d' }], dry_run: false }));
  });

  it('asks before a component ends, and does nothing on no', async () => {
    const done = serve();
    const { user, row } = await openPage();
    row.focus();
    await user.keyboard('{Enter}{Delete}');
    const dialog = await screen.findByRole('dialog', { name: /End Sensor0/ });
    await user.click(within(dialog).getByRole('button', { name: en.plan.cancel }));
    expect(screen.queryByRole('dialog')).toBeNull();
    expect(done.map((one) => one.dry_run)).toEqual([true]);
  });

  it('keeps typed values until they are applied, and refuses bad ones', async () => {
    const done = serve();
    const { user, row } = await openPage();
    await user.click(row);
    const field = screen.getByLabelText(/^gain/);
    await user.clear(field);
    await user.type(field, '9');
    expect(screen.getByText(en.misfit.mustSatisfy('0<=x<=5'))).toBeTruthy();
    expect(screen.getByRole('button', { name: /^Apply/ }).hasAttribute('disabled')).toBe(true);

    await user.click(screen.getByRole('treeitem', { name: /Camera0/ }));
    await user.click(row);
    const again = screen.getByLabelText(/^gain/);
    expect((again as HTMLInputElement).value).toBe('9');
    await user.clear(again);
    await user.type(again, '2{Enter}');
    await waitFor(() => expect(done.at(-1)).toEqual({
      actions: [{ do: 'configure', component: '/localhost/Sensor0.rtc', set: 'default', values: { gain: '2' } }], dry_run: false,
    }));
  });

  it('goes to what the palette finds', async () => {
    serve();
    const { user } = await openPage();
    await user.keyboard('/');
    await user.type(await screen.findByRole('combobox', { name: en.palette.placeholder }), 'mot');
    await user.keyboard('{Enter}');
    expect(screen.getByRole('treeitem', { name: /Motor0/ }).getAttribute('aria-selected')).toBe('true');
    expect(screen.getByRole('heading', { name: 'Motor0' })).toBeTruthy();
  });

  it('changes nothing where the server is read-only', async () => {
    const done = serve(true);
    const { user, row } = await openPage();
    row.focus();
    await user.keyboard('{Enter}c{Delete}{Control>}z{/Control}');
    expect(screen.queryByRole('dialog')).toBeNull();
    expect(screen.getByRole('button', { name: en.act.activate }).hasAttribute('disabled')).toBe(true);
    expect(done).toEqual([]);
  });
});
