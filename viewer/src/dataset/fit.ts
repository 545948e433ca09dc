/** Type as large as its place allows. */

/** Below this size text is no more read from afar, px: it is scrolled instead. */
const LEAST_PX = 20;
/** A single word need not fill the wall, px. */
const MOST_PX = 128;

/**
 * The largest whole size from `least` to `most` that `fits`: which must hold for every smaller size too. `least` where none
 * does.
 */
export function largestSize(fits: (px: number) => boolean, least = LEAST_PX, most = MOST_PX): number {
  let [low, high] = [least, most];
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (fits(middle)) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** Sets the size of `text` so that it fills `box`, and breaks no word where that can be. */
export function fitText(text: HTMLElement, box: HTMLElement): void {
  if (box.clientHeight === 0 || box.clientWidth === 0) return;
  text.style.overflowWrap = "normal";
  const size = largestSize((px) => {
    text.style.fontSize = `${px}px`;
    return text.offsetHeight <= box.clientHeight && text.scrollWidth <= text.clientWidth;
  });
  text.style.fontSize = `${size}px`;
  text.style.overflowWrap = "anywhere";
}
