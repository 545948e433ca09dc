/** What geometry is made of, as plain numbers. */
import type { BufferAttribute, InterleavedBufferAttribute } from "three";

export type Attribute = BufferAttribute | InterleavedBufferAttribute;

/** Three numbers a vertex. */
export function numbersOf(attribute: Attribute): Float32Array {
  const numbers = new Float32Array(attribute.count * 3);
  for (let i = 0; i < attribute.count; ++i) {
    numbers[3 * i] = attribute.getX(i);
    numbers[3 * i + 1] = attribute.getY(i);
    numbers[3 * i + 2] = attribute.getZ(i);
  }
  return numbers;
}
