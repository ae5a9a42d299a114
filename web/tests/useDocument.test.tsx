import { act, renderHook, waitFor } from '@testing-library/react';
import type { ReactNode } from 'react';
import { describe, expect, it } from 'vitest';

import { createSubscriptions } from '../src/server/subscriptions';
import type { Picture } from '../src/rooms/document/types';
import { useDocument } from '../src/rooms/document/useDocument';
import { EditorContext } from '../src/shell/contexts';
import type { Editor } from '../src/shell/editor';

/** A document whose edits are answered when the test says so. */
async function opened() {
  const asked: string[] = [];
  const waiting: ((picture: Picture) => void)[] = [];
  const post = (path: string) => {
    asked.push(path);
    return new Promise<Picture>((answer) => waiting.push(answer));
  };
  const subscriptions = createSubscriptions();
  const editor = { api: { post }, subscriptions } as unknown as Editor;
  const wrapper = ({ children }: { children: ReactNode }) => <EditorContext value={editor}>{children}</EditorContext>;
  const { result } = renderHook(() => useDocument('a.xml'), { wrapper });
  const answer = (revision: number) => act(async () => {
    waiting.shift()?.({ id: '1', revision, undo: '' } as Picture);
    await Promise.resolve();
  });
  const notify = (revision: number) => act(() => subscriptions.notify('document', { id: '1', revision }));
  await answer(1);
  await waitFor(() => expect(result.current.picture?.revision).toBe(1));
  return { asked, answer, notify, result };
}

describe('a document', () => {
  it('shows an edit by its answer, though the news of it come first', async () => {
    const { asked, answer, notify, result } = await opened();
    act(() => void result.current.edit({ do: 'arrange' }));
    notify(2);
    expect(asked).toEqual(['/api/documents/open', '/api/documents/1/edit']);
    await answer(2);
    await waitFor(() => expect(result.current.picture?.revision).toBe(2));
    expect(asked).toHaveLength(2);
  });

  it('asks for what another page did meanwhile', async () => {
    const { asked, answer, notify, result } = await opened();
    act(() => void result.current.edit({ do: 'arrange' }));
    notify(3);
    await answer(2);
    await waitFor(() => expect(asked.at(-1)).toBe('/api/documents/1'));
    await answer(3);
    await waitFor(() => expect(result.current.picture?.revision).toBe(3));
    notify(4);
    await waitFor(() => expect(asked).toHaveLength(4));
  });
});
