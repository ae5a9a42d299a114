import { describe, expect, it } from 'vitest';

import { createString, typeKey } from '../src/model/creating';

const creation = { type: 'Motor', instance: '', slave: '', parameters: '' };

describe('the create string', () => {
  it('is the type alone when nothing is wished', () => {
    expect(createString(creation)).toBe('Motor');
  });

  it('escapes what has a meaning in it', () => {
    expect(createString({ ...creation, instance: 'M 1', slave: 's1', parameters: 'conf.default.text=a&b=c?%\n\n x = 1 ' }))
      .toBe('Motor?instance_name=M 1&manager_name=s1&conf.default.text=a%26b%3Dc%3F%25&x=1');
  });

  it('is refused where a line is no pair', () => {
    expect(createString({ ...creation, parameters: 'gain 2' })).toBeNull();
  });
});

it('names a type in full where two have the same name', () => {
  const [one, other] = ['a', 'b'].map((vendor) => ({ name: 'Motor', id: `RTC:${vendor}:x:Motor:C++:1.0`, module: '' }));
  if (!one || !other) throw new Error('two types');
  expect([typeKey([one], one), typeKey([one, other], one)]).toEqual(['Motor', one.id]);
});
