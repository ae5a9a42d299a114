import { describe, expect, it } from 'vitest';

import { EventStreamParser, type ServerEvent } from '../src/server/sse';

const bytes = (text: string): Uint8Array => new TextEncoder().encode(text);
const TEXT = ': alive\n\nevent: change\ndata: {"name":\ndata: "モータ😀"}\n\ndata: plain\r\n\r\nevent: empty\n\n';
const EVENTS: ServerEvent[] = [{ event: 'change', data: '{"name":\n"モータ😀"}' }, { event: 'message', data: 'plain' }];

describe('the event stream', () => {
  it('reads whole events and skips comments and events without data', () => {
    expect(new EventStreamParser().feed(bytes(TEXT))).toEqual(EVENTS);
  });

  it('reads the same wherever the chunks break', () => {
    const all = bytes(TEXT);
    for (let size = 1; size <= 7; size += 1) {
      const parser = new EventStreamParser();
      const events: ServerEvent[] = [];
      for (let at = 0; at < all.length; at += size) events.push(...parser.feed(all.slice(at, at + size)));
      expect(events, `chunks of ${size}`).toEqual(EVENTS);
    }
  });

  it('does not end an event between CR and LF', () => {
    const parser = new EventStreamParser();
    expect(parser.feed(bytes('data: a\r'))).toEqual([]);
    expect(parser.feed(bytes('\ndata: b\r\n\r\n'))).toEqual([{ event: 'message', data: 'a\nb' }]);
  });

  it('keeps the spaces of data but the first', () => {
    expect(new EventStreamParser().feed(bytes('data:  x \n\n'))).toEqual([{ event: 'message', data: ' x ' }]);
  });
});
