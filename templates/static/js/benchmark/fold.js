// Unfolds the part of the page that the address or a link names.
import { around } from "../dom.js";

function unfold() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (let part = target?.closest("details"); part; part = part.parentElement?.closest("details")) part.open = true;
  if (target) target.scrollIntoView();
}

window.addEventListener("hashchange", unfold);
// A link to where the address points already does not change it.
document.addEventListener("click", (event) => {
  const link = around(event.target, 'a[href^="#"]', HTMLAnchorElement);
  if (link && link.hash === location.hash) unfold();
});
if (location.hash) unfold();
