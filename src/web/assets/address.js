// The address of this page: back and forward load the run that they lead to, links to a part of the page only scroll.
let shown = location.search;

/** The page shows another run from here on. */
export function moveTo(address) {
  history.pushState(null, '', address);
  shown = location.search;
}

addEventListener('popstate', () => location.search !== shown && location.reload());
