import { expect, test } from 'vitest';

import { checkCommand, countsOf, findingsOn, fresh, systemOf } from '../src/rooms/document/picture';
import type { DocumentComponent, Finding, Picture } from '../src/rooms/document/types';
import { component } from './records';

const WORDS = { severity: { error: 'error', warning: 'warning', note: 'note' }, untyped: 'untyped', required: 'required', optional: 'optional', included: 'included' };

const part = (id: string, more: Partial<DocumentComponent> = {}): DocumentComponent =>
  ({ ...component(id), id, origin: '', path: '', is_required: true, direction: '', source: '', declared: {}, ...more });

const finding = (severity: Finding['severity'], on: string, rule = 'data-type'): Finding => ({ severity, rule, on, text: `${severity} of ${on}`, allowed: '' });

const picture = (components: DocumentComponent[], findings: Finding[] = []): Picture => ({
  id: '1', file: '', name: 'S', is_changed: false, revision: 3, form: 'xml', undo: null, redo: null,
  profile: { vendor: '', name: '', version: '', abstract: '', comment: '', created: '', updated: '', log: [] },
  variables: [], includes: [], components, connectors: [], layout: { revision: 3, width: 0, height: 0, boxes: {}, paths: {} }, places: {}, bends: {}, findings,
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
