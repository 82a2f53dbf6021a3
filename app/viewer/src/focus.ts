/** Where the keyboard goes when what has the focus goes away: to what stood around it, so that Tab goes on from there. */

/** What has the focus, and all that stands around it, from the inside out. */
let around: readonly Element[] = [];

/** See to it that the focus is never lost within an element. */
export function keepFocus(within: HTMLElement): void {
  addEventListener("pointerdown", () => (around = []), true);
  within.addEventListener("focusin", (event) => (around = ancestors(event.target as Element)));
  new MutationObserver(() => {
    if (!around.length || around[0].isConnected || document.activeElement !== document.body) return;
    const next = around.find((each) => each.isConnected) as HTMLElement | undefined;
    if (next && !next.hasAttribute("tabindex")) next.tabIndex = -1;
    next?.focus({ preventScroll: true });
  }).observe(within, { childList: true, subtree: true });
}

function ancestors(element: Element): Element[] {
  const found: Element[] = [];
  for (let each: Element | null = element; each; each = each.parentElement) found.push(each);
  return found;
}
