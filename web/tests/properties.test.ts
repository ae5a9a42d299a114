import { beforeEach, describe, expect, it, vi } from 'vitest';

import { isFileName, layoutOf, moved, textOf } from '../src/rooms/properties/layout';
import { below, ownersOf, rowsOf } from '../src/rooms/properties/tree';
import { createPanel, readGui, type PanelElement, type Source, type Told } from '../src/rooms/properties/widgets';
import { component } from './records';

const GOOD: Told = { quality: 'good', code: '', isRaw: false };

describe('a page that was put together', () => {
  it('is read as it was saved', () => {
    const layout = { title: 'A "home" <1>', items: [{ target: 'robots/r1.location', kind: 'map' }, { target: 'a.b', kind: 'slider', min: '-1', max: '1' }, { target: '/localhost/A 0.rtc.state', kind: '' }] };
    expect(layoutOf(textOf(layout))).toEqual(layout);
  });
  it('has its items moved within its bounds', () => {
    const items = ['a', 'b', 'c'].map((target) => ({ target, kind: '' }));
    expect(moved(items, 0, 1).map((one) => one.target)).toEqual(['b', 'a', 'c']);
    expect(moved(items, 0, -1)).toBe(items);
    expect(moved(items, 2, 1)).toBe(items);
  });
  it('has a name that a storage takes', () => {
    expect(['drive', 'a-b_1'].every(isFileName)).toBe(true);
    expect(['', 'a/b', '..', 'gui', 'a b'].some(isFileName)).toBe(false);
  });
  it('is nothing else', () => {
    expect(() => layoutOf('<marker/>')).toThrow();
  });
});

describe('the tree', () => {
  const owners = ownersOf([{ target: 'robots/r1', types: ['mobilerobot'] }], { components: new Map([['c', component('Motor0')]]), managers: new Map() });
  const names = new Map([['robots/r1', ['speed', 'sensors.eye.markers', 'sensors.eye.range']]]);
  it('shows what lies directly below', () => {
    expect(below(names.get('robots/r1') ?? [], '')).toEqual(['speed', 'sensors']);
    expect(below(names.get('robots/r1') ?? [], 'sensors')).toEqual(['sensors.eye']);
  });
  it('opens branch by branch', () => {
    const open = new Set(['robots/r1', 'robots/r1.sensors']);
    expect(rowsOf(owners, names, open, '').map((row) => `${row.level} ${row.name}`)).toEqual(['1 robots/r1', '2 speed', '2 sensors', '3 eye', '1 /localhost/Motor0.rtc', '1 /localhost']);
  });
  it('finds properties by a part of their target', () => {
    expect(rowsOf(owners, names, new Set(), 'r1 eye').map((row) => row.target)).toEqual(['robots/r1.sensors.eye.markers', 'robots/r1.sensors.eye.range']);
    expect(rowsOf(owners, names, new Set(), 'Motor').map((row) => row.target)).toEqual(['/localhost/Motor0.rtc']);
  });
});

const set = vi.fn<Source['set']>(() => Promise.resolve());
const source = (isReadOnly = false): Source => ({ isReadOnly, set, get: () => Promise.resolve(''), text: () => Promise.resolve(''), component: () => undefined });

function drawn(text: string, isReadOnly = false): PanelElement {
  const panel = createPanel();
  document.body.append(panel);
  panel.redraw(readGui(text), source(isReadOnly));
  return panel;
}
const found = (panel: PanelElement, selector: string): HTMLElement => {
  const element = panel.querySelector<HTMLElement>(selector);
  if (!element) throw new Error(`${selector} is not there`);
  return element;
};

// jsdom lays nothing out: all is seen.
class Observer {
  constructor(private readonly tell: (entries: { isIntersecting: boolean }[]) => void) {}
  observe = () => this.tell([{ isIntersecting: true }]);
  disconnect = () => undefined;
}
Object.assign(globalThis, { IntersectionObserver: Observer });

beforeEach(() => {
  document.body.replaceChildren();
  set.mockClear();
});

describe('a panel that is drawn anew', () => {
  const page = (max: string, more = '') => `<gui kind="group" name="s"><gui kind="slider" name="s.a" min="0" max="${max}" access="rw"/><gui kind="toggle" name="s.b" access="rw"/>${more}</gui>`;
  it('keeps what is described as before, and the values of what is not', () => {
    const panel = drawn(page('1'));
    panel.show('s.a', '1', GOOD);
    const [slider, toggle] = ['rt-slider', 'rt-toggle'].map((name) => found(panel, name));
    panel.redraw(readGui(page('2')), source());
    expect(found(panel, 'rt-toggle')).toBe(toggle);
    expect(found(panel, 'rt-slider')).not.toBe(slider);
    const field = found(panel, 'rt-slider input') as HTMLInputElement;
    expect([field.max, field.value]).toEqual(['2', '1']);
  });
  it('draws all where names have come', () => {
    const panel = drawn(page('1'));
    panel.redraw(readGui(page('1', '<gui kind="label" name="s.c" access="r"/>')), source());
    expect(panel.querySelectorAll('[data-kind]')).toHaveLength(3);
  });
});

describe('a joystick', () => {
  const text = '<gui kind="joystick" name="r.velocity" access="rw" labels="(x y)" after="0.5"/>';
  const sent = () => set.mock.calls.map(([, value, held]) => `${value} ${held ? held.rest : 'let go'}`);
  const held = async (release: (panel: PanelElement, pad: HTMLElement) => void) => {
    const panel = drawn(text);
    const pad = found(panel, '.pad');
    pad.dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowUp' }));
    await vi.waitFor(() => expect(sent()).toEqual(['(1 0) (0 0)']));
    release(panel, pad);
    await vi.waitFor(() => expect(sent().at(-1)).toBe('(0 0) let go'));
  };
  it('is let go with its key', () => held((_, pad) => pad.dispatchEvent(new KeyboardEvent('keyup', { key: 'ArrowUp' }))));
  it('is let go when it loses the focus', () => held((_, pad) => pad.dispatchEvent(new FocusEvent('blur'))));
  it('is let go when the window loses the focus', () => held(() => window.dispatchEvent(new Event('blur'))));
  it('is let go when the page is left', () => held(() => window.dispatchEvent(new Event('pagehide'))));
  it('is let go when the tab is hidden', () => held(() => {
    vi.spyOn(document, 'hidden', 'get').mockReturnValueOnce(true);
    document.dispatchEvent(new Event('visibilitychange'));
  }));
  it('is let go when the connection is lost', () => held((panel) => panel.lock(true)));
  it('is let go when its page is shown no longer', () => held((panel) => panel.remove()));
  it('does nothing on a page that is read-only', () => {
    found(drawn(text, true), '.pad').dispatchEvent(new KeyboardEvent('keydown', { key: 'ArrowUp' }));
    expect(set).not.toHaveBeenCalled();
  });
});

describe('a map', () => {
  const text = '<gui kind="group" name="r"><gui kind="map" name="r.location" access="r" frame="world" layers="(&quot;w.hall&quot; &quot;m.markers&quot;)"/>' +
    '<gui kind="button" name="r.moveto" access="rw"><gui kind="marker" name="target" type="marker" argument="true"/></gui><gui kind="marker" name="r.aim" type="marker" access="rw"/>' +
    '<gui kind="text" name="w.hall" type="any" access="rw"/></gui>';
  const press = (panel: PanelElement, ...keys: string[]) => keys.forEach((key) => found(panel, 'svg.map').dispatchEvent(new KeyboardEvent('keydown', { key })));
  const shown = async (isReadOnly = false) => {
    const panel = drawn(text, isReadOnly);
    panel.show('r.location', '(1 2 0 0 0 0)', GOOD);
    panel.show('w.hall', '((0 0) (4 0) (4 4) (0 4))', GOOD);
    panel.show('m.markers', '(<marker><location>(3 3)</location><name>ball</name></marker> <marker><location>(9 9)</location><frame>base</frame></marker>)', GOOD);
    await vi.waitFor(() => expect(panel.querySelector('svg.map text')).not.toBeNull());
    return panel;
  };
  const choose = (panel: PanelElement, tool: string, target: string) => {
    (found(panel, '.tools select') as HTMLSelectElement).value = target;
    found(panel, `[data-tool="${tool}"]`).click();
  };
  it('shows its own place, places and outlines of its layers, and nothing of another frame', async () => {
    const panel = await shown();
    expect([...panel.querySelectorAll('svg.map text')].map((one) => one.textContent)).toEqual(['hall', 'r', 'ball']);
    panel.show('r.location', '(2 2 0 0 0 0)', GOOD);
    await vi.waitFor(() => expect(found(panel, 'rt-map ul').textContent).toContain('r: 2 2'));
  });
  it('offers what takes a marker or an area', async () => {
    const panel = await shown();
    expect([...panel.querySelectorAll('.tools option')].map((one) => one.textContent)).toEqual(['r.moveto', 'r.aim', 'w.hall']);
  });
  it('sets a point by keys', async () => {
    const panel = await shown();
    choose(panel, 'point', 'r.moveto');
    press(panel, 'ArrowRight', 'ArrowUp', 'Enter');
    await vi.waitFor(() => expect(set).toHaveBeenCalledWith('r.moveto', '<marker><location>(2.1 2.1)</location><frame>world</frame></marker>'));
  });
  it('sets a region as somewhere: its middle, its extent and its corners', async () => {
    const panel = await shown();
    choose(panel, 'region', 'r.aim');
    press(panel, 'Enter', ...Array<string>(10).fill('ArrowRight'), 'Enter', ...Array<string>(10).fill('ArrowUp'), 'Enter');
    [...panel.querySelectorAll<HTMLElement>('.tools button')].at(-1)?.click();
    await vi.waitFor(() => expect(set).toHaveBeenCalledWith('r.aim',
      '<marker><location>(2.67 2.33)</location><frame>world</frame><size>(1 1)</size><region>((2 2) (3 2) (3 3))</region></marker>'));
  });
  it('sets an area as its corners', async () => {
    const panel = await shown();
    choose(panel, 'region', 'w.hall');
    press(panel, 'Enter', 'ArrowRight', 'Enter', 'ArrowUp', 'Enter');
    [...panel.querySelectorAll<HTMLElement>('.tools button')].at(-1)?.click();
    await vi.waitFor(() => expect(set).toHaveBeenCalledWith('w.hall', '((2 2) (2.1 2) (2.1 2.1))'));
  });
  it('keeps what else a marker has, and ends with Escape', async () => {
    const panel = await shown();
    panel.show('r.aim', '<marker><location>(1 1 5)</location><name>aim</name></marker>', GOOD);
    choose(panel, 'point', 'r.aim');
    press(panel, 'Escape', 'Enter');
    expect(set).not.toHaveBeenCalled();
    choose(panel, 'point', 'r.aim');
    press(panel, 'Enter');
    await vi.waitFor(() => expect(set).toHaveBeenCalledWith('r.aim', '<marker><location>(2 2 5)</location><frame>world</frame><name>aim</name></marker>'));
  });
  it('has no tools on a page that is read-only', async () => {
    expect((await shown(true)).querySelector('.tools')).toBeNull();
  });
});
