/** Values of messages, read with care: what is missing or of a wrong kind becomes the harmless value of its kind. */

export type Fields = Record<string, unknown>;

/** Lists longer than this are cut: no session has so many of anything. */
const MOST = 256;
/** Texts longer than this are cut. */
const LONGEST = 500;

export function fieldsOf(value: unknown): Fields {
  return typeof value === "object" && value !== null && !Array.isArray(value) ? (value as Fields) : {};
}
export function number(value: unknown, otherwise = 0): number {
  return typeof value === "number" && Number.isFinite(value) ? value : otherwise;
}
export function numberOrNull(value: unknown): number | null {
  return typeof value === "number" && Number.isFinite(value) ? value : null;
}
export function text(value: unknown, otherwise = "", longest = LONGEST): string {
  return typeof value === "string" ? value.slice(0, longest) : otherwise;
}
/** A whole number from 0 to `most`. */
export function count(value: unknown, most: number): number {
  return Math.min(most, Math.max(0, Math.round(number(value))));
}
export function share(value: unknown): number {
  return Math.min(1, Math.max(0, number(value)));
}
export function list<T>(value: unknown, read: (fields: Fields) => T): T[] {
  return Array.isArray(value) ? value.slice(0, MOST).map((one) => read(fieldsOf(one))) : [];
}
export function texts(value: unknown): string[] {
  return Array.isArray(value) ? value.slice(0, MOST).filter((one) => typeof one === "string").map((one) => text(one)) : [];
}
export function idOf(value: unknown): string | number {
  return typeof value === "number" ? number(value) : text(value);
}
