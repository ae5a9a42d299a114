import { expect, test } from 'vitest';

import { between, withPoint } from '../src/canvas/bends';
import { propertiesOf, wishOf } from '../src/model/connecting';
import type { Box } from '../src/model/types';
import { checkCommand, countsOf, findingsOn, fresh, layoutOf, systemOf, turnedBox } from '../src/rooms/document/picture';
import type { DocumentComponent, Finding, Picture } from '../src/rooms/document/types';
import { component, port, wire } from './records';

const WORDS = { severity: { error: 'error', warning: 'warning', note: 'note' }, untyped: 'untyped', required: 'required', optional: 'optional', included: 'included' };

const part = (id: string, more: Partial<DocumentComponent> = {}): DocumentComponent =>
  ({ ...component(id), id, origin: '', path: '', is_required: true, direction: '', source: '', declared: {}, ...more });

const finding = (severity: Finding['severity'], on: string, rule = 'data-type'): Finding => ({ severity, rule, on, text: `${severity} of ${on}`, allowed: '' });

const picture = (components: DocumentComponent[], findings: Finding[] = []): Picture => ({
  id: '1', file: '', name: 'S', is_changed: false, revision: 3, form: 'xml', undo: null, redo: null,
  profile: { vendor: '', name: '', version: '', abstract: '', comment: '', created: '', updated: '', log: [] },
  variables: [], includes: [], groups: [], components, connectors: [], layout: { revision: 3, width: 0, height: 0, boxes: {}, paths: {} }, places: {}, bends: {}, findings,
});

test('a box tells the worst that is found about it, by look and word', () => {
  const system = systemOf(picture([part('A'), part('B'), part('C'), part('D', { is_required: false }), part('E', { origin: '/x.xml' })], [
    finding('warning', 'A'), finding('error', 'A'), finding('warning', 'B', 'no-profile'), finding('note', 'C'),
  ]), WORDS);
  const told = [...system.components.values()].map(({ look, word }) => `${look} ${word}`);
  expect(told).toEqual(['error error', 'unknown untyped', 'created required', 'created optional', 'created included']);
  expect(system.components.get('A')?.remark).toBe('error of A');
});

test('findings are put in order of their weight, and counted', () => {
  const all = [finding('note', 'A'), finding('error', 'A'), finding('warning', '')];
  expect(findingsOn(all).get('A')?.map((one) => one.severity)).toEqual(['error', 'note']);
  expect(countsOf(all)).toEqual({ error: 1, warning: 1, note: 1 });
});

test('what was added is what was not there before', () => {
  expect(fresh(picture([part('A')]), picture([part('A'), part('B')]))).toBe('B');
  expect(fresh(picture([part('A')]), picture([part('A')]))).toBeUndefined();
});

test('the command of the check can be typed, whatever the names are', () => {
  expect(checkCommand('/r/a.xml', ['/r'])).toBe('rtprofile check --components /r /r/a.xml');
  expect(checkCommand("/r/it's a.xml", [])).toBe(`rtprofile check '/r/it'"'"'s a.xml'`);
});

const box: Box = { x: 0, y: 0, width: 100, height: 90, parent: null, kind: 'component', is_folded: false, ports: { in: { side: 'left', y: 52 }, a: { side: 'right', y: 52 }, b: { side: 'right', y: 72 } } };

test('a box turned to the left has its sides exchanged, one turned down its in ports above', () => {
  const ins = new Set(['in']);
  expect(turnedBox(box, 'RIGHT', ins)).toBe(box);
  expect(turnedBox(box, 'LEFT', ins).ports).toMatchObject({ in: { side: 'right' }, a: { side: 'left' } });
  const down = turnedBox(box, 'DOWN', ins);
  expect([down.width, down.ports]).toEqual([144, { in: { side: 'top', y: 0, x: 72 }, a: { side: 'bottom', y: 0, x: 36 }, b: { side: 'bottom', y: 0, x: 108 } }]);
  expect(turnedBox(box, 'UP', ins).ports).toMatchObject({ in: { side: 'bottom' }, a: { side: 'top' } });
});

test('a wire at a turned box leaves the path of the layout', () => {
  const shown = { ...picture([part('/localhost/A.rtc', { ports: [port('out', 'out')] }), part('/localhost/B.rtc')]), connectors: [{ ...wire('w', 'A.out', 'B.in'), origin: '' }] };
  shown.layout = { ...shown.layout, boxes: { '/localhost/A.rtc': box, '/localhost/B.rtc': box }, paths: { w: [[0, 0], [1, 1]] } };
  expect(layoutOf(shown).paths).toEqual(shown.layout.paths);
  shown.places = { '/localhost/A.rtc': { x: 5, y: 5, direction: 'DOWN' } };
  expect(layoutOf(shown).paths).toEqual({});
});

test('bend points are moved and taken between those that are there', () => {
  expect(withPoint([[1, 1], [5, 5]], 1, [3, 3], true)).toEqual([[1, 1], [3, 3], [5, 5]]);
  expect(withPoint([[1, 1], [5, 5]], 1, [6, 6], false)).toEqual([[1, 1], [6, 6]]);
  expect(between([[0, 0], [10, 4], [10, 10]])).toEqual([[5, 2], [10, 7]]);
});

test('the form of a connector has what its properties say, and says them again', () => {
  const stated = { 'dataport.dataflow_type': 'push', 'dataport.subscription_type': 'periodic', 'dataport.publisher.push_rate': '5', 'dataport.inport.buffer.length': '8', other: 'x' };
  expect(propertiesOf(wishOf({ ...stated, BEND_POINT: '{1:(1,2)}' }))).toEqual(stated);
});
