// The arrays' format, against bytes written by hand.
import assert from 'node:assert/strict';
import { deflateSync } from 'node:zlib';
import { it } from 'node:test';
import { unpack, unpackPositions } from '../src/packed.js';

const pack = (bytes, components, count, more = {}) => ({
  components,
  count,
  data: deflateSync(Buffer.from(bytes)).toString('base64'),
  ...more,
});

it('adds up zigzag differences of each component', async () => {
  // 1, −1, then +63, −64, then 300 as two bytes (600 = 0x58 + 4 · 128) and 0.
  assert.deepEqual(
    [...(await unpack(pack([2, 1, 126, 127, 0xd8, 4, 0], 2, 3)))],
    [1, -1, 64, -65, 364, -65],
  );
});

it('reads numbers beyond 2³¹ of code', async () => {
  // zigzag of −2³⁰·2 + … : 2³¹ − 1 is code 2³² − 2 = fe ff ff ff 0f.
  assert.deepEqual([...(await unpack(pack([0xfe, 0xff, 0xff, 0xff, 0x0f], 1, 1)))], [2147483647]);
});

it('refuses data that are too short or too long', async () => {
  await assert.rejects(unpack(pack([2], 1, 2)), /cut short/);
  await assert.rejects(unpack(pack([2, 2, 2], 1, 2)), /too long/);
});

it('scales and shifts positions', async () => {
  const positions = await unpackPositions(
    pack([2, 4, 6, 2, 2, 2], 3, 2, { step: 0.5 }),
    [10, 20, 30],
  );
  assert.deepEqual([...positions], [10.5, 21, 31.5, 11, 21.5, 32]);
});
