// Reads the arrays that src/report/packed_array.cc writes: deflated differences as variable-length
// numbers.

async function inflate(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; ++i) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Int32Array of count × components. Throws when the data do not hold so many numbers. */
export async function unpack(packed) {
  const bytes = await inflate(packed.data);
  const stride = packed.components;
  const values = new Int32Array(packed.count * stride);
  let at = 0;
  for (let i = 0; i < values.length; ++i) {
    let code = 0;
    let factor = 1;
    let byte;
    do {
      if (at >= bytes.length) throw new Error('a packed array is cut short');
      byte = bytes[at++];
      code += (byte & 0x7f) * factor;
      factor *= 128;
    } while (byte & 0x80);
    const difference = code % 2 ? -(code + 1) / 2 : code / 2;
    values[i] = (i < stride ? 0 : values[i - stride]) + difference;
  }
  if (at !== bytes.length) throw new Error('a packed array is too long');
  return values;
}

/** Float32Array of positions, in metres from the iteration's origin plus `shift` [x, y, z]. */
export async function unpackPositions(packed, shift = [0, 0, 0]) {
  const steps = await unpack(packed);
  const positions = new Float32Array(steps.length);
  for (let i = 0; i < steps.length; i += 3) {
    for (let k = 0; k < 3; ++k) positions[i + k] = steps[i + k] * packed.step + shift[k];
  }
  return positions;
}
