import { describe, expect, it } from 'vitest';

import { NO_WISH, badLine, meaningful, propertiesOf } from '../src/model/connecting';

describe('properties of a connector', () => {
  it('sends nothing of what was left alone', () => {
    expect(propertiesOf(NO_WISH)).toEqual({});
  });

  it('leaves out what makes no sense together', () => {
    const flush = { ...NO_WISH, subscription: 'flush', policy: 'skip', skip: '3', rate: '10' };
    expect(propertiesOf(flush)).toEqual({ 'dataport.subscription_type': 'flush' });
    expect(meaningful({ ...NO_WISH, dataflow: 'pull' })).toEqual({ subscription: false, policy: false, rate: false, skip: false });
  });

  it('names buffers by their end and takes further lines', () => {
    const wish = { ...NO_WISH, subscription: 'periodic', rate: '10', target: { length: '4', full: 'block', empty: '' }, further: 'a.b = c=d\n\n' };
    expect(propertiesOf(wish)).toEqual({
      'dataport.subscription_type': 'periodic', 'dataport.publisher.push_rate': '10',
      'dataport.inport.buffer.length': '4', 'dataport.inport.buffer.write.full_policy': 'block', 'a.b': 'c=d',
    });
  });

  it('finds the line that is no property', () => {
    expect([badLine('a=1\nb'), badLine('=1'), badLine('a=')]).toEqual(['b', '=1', null]);
  });
});
