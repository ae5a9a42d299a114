import { describe, expect, it } from 'vitest';

import { misfit, parseConstraint, widgetFor } from '../src/model/parameters';

describe('constraints', () => {
  it.each([
    ['0<=x<=50', '50', true], ['0<=x<=50', '50.1', false], ['0<x<50', '0', false], ['x>0', '1e-3', true], ['x>0', '0', false],
    ['x<=-2', '-2', true], ['10>=x>=1', '11', false], ['-1.5 <= x', '-1.6', false], ['0<=x<=9', '1,2,3', true], ['0<=x<=9', '1,22', false],
    ['(a, b)', 'b', true], ['(a, b)', 'c', false], ['(a, b)', 'a,b', false],
  ])('%s for %s', (rule, text, isFit) => {
    expect(misfit(text, rule) === null).toBe(isFit);
  });

  it('says why a value is bad', () => {
    expect(misfit('x', '0<=x<=5')).toEqual({ kind: 'not-a-number' });
    expect(misfit('', '0<=x<=5')).toEqual({ kind: 'not-a-number' });
    expect(misfit('9', '0<=x<=5')).toEqual({ kind: 'must-satisfy', rule: '0<=x<=5' });
    expect(misfit('a,z', '(a, b)', 'checkbox')).toEqual({ kind: 'not-offered', value: 'z' });
  });

  it('leaves to the server what it cannot read', () => {
    expect(parseConstraint('as you like')).toBeNull();
    expect(misfit('anything', '{0<=x, x<9}')).toBeNull();
  });
});

describe('widgets', () => {
  it('is a slider only between two bounds', () => {
    expect(widgetFor('slider.0.1', '0<=x<=1')).toEqual({ kind: 'slider', low: 0, high: 1, step: 0.1 });
    expect(widgetFor('slider', '0<=x<=50')).toEqual({ kind: 'slider', low: 0, high: 50, step: 0.5 });
    expect(widgetFor('slider.5', 'x>0')).toEqual({ kind: 'spin', low: 0, high: null, step: 5 });
  });

  it('offers choices where the constraint lists them, else a text field', () => {
    expect(widgetFor('radio', '(a,b)')).toEqual({ kind: 'radio', choices: ['a', 'b'] });
    expect(widgetFor('ordered_list', '(a,b)')).toEqual({ kind: 'ordered_list', choices: ['a', 'b'] });
    expect(widgetFor('radio', '')).toEqual({ kind: 'text' });
    expect(widgetFor('nonsense.1', '0<=x<=1')).toEqual({ kind: 'text' });
  });
});
