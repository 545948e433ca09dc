/** Numbers as a person reads them. A missing one is a dash. */

const MISSING = "–";

export function fixed(value: number | null, digits: number): string {
  return value === null || !Number.isFinite(value) ? MISSING : value.toFixed(digits);
}

/** 4.2 ms, 87 ms, 3.1 s, 12 min. */
export function milliseconds(value: number | null): string {
  if (value === null) return MISSING;
  const size = Math.abs(value);
  if (size < 9.95) return `${value.toFixed(1)} ms`;
  if (size < 999.5) return `${value.toFixed(0)} ms`;
  if (size < 99_950) return `${(value / 1000).toFixed(1)} s`;
  if (size < 7_200_000) return `${(value / 60_000).toFixed(0)} min`;
  return `${(value / 3_600_000).toFixed(1)} h`;
}

/** A share as a percentage: 0, 0.4 %, 12 %. */
export function percentage(value: number | null): string {
  if (value === null) return MISSING;
  const percent = value * 100;
  return percent === 0 ? "0 %" : `${percent.toFixed(percent < 9.95 ? 1 : 0)} %`;
}

/** 1:05 or 1:02:03. */
export function clock(seconds: number): string {
  const whole = Math.max(0, Math.floor(seconds));
  const two = (value: number) => String(value).padStart(2, "0");
  const hours = Math.floor(whole / 3600);
  const minutes = Math.floor(whole / 60) % 60;
  return hours > 0 ? `${hours}:${two(minutes)}:${two(whole % 60)}` : `${minutes}:${two(whole % 60)}`;
}

/** How long ago, roughly: "just now", "40 s ago", "3 min ago". */
export function ago(seconds: number): string {
  if (seconds < 5) return "just now";
  if (seconds < 90) return `${Math.round(seconds)} s ago`;
  if (seconds < 5400) return `${Math.round(seconds / 60)} min ago`;
  return `${Math.round(seconds / 3600)} h ago`;
}

/** How long ago, to the minute: "40 s ago", "12 min ago", "1 h 12 min ago". */
export function agoToTheMinute(seconds: number): string {
  if (seconds < 3570) return ago(seconds);
  const minutes = Math.round(seconds / 60);
  return minutes % 60 === 0 ? `${minutes / 60} h ago` : `${Math.floor(minutes / 60)} h ${minutes % 60} min ago`;
}

/** "zygomaticus_upper_L" reads better as "zygomaticus upper L". */
export function sensorLabel(name: string): string {
  return name.replaceAll("_", " ");
}
