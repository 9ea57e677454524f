// Quasar gives a list its place within 0.4 s of being opened, if it has a size by then, and leaves it invisible otherwise. The
// options of a select may come later on a busy computer: then the list is placed again, as Quasar does when something scrolls.
const portals = new MutationObserver((changes) => {
  for (const { addedNodes } of changes) {
    for (const portal of addedNodes) if (portal.id?.startsWith("q-portal--menu")) follow(portal);
  }
});
addEventListener("DOMContentLoaded", () => portals.observe(document.body, { childList: true }));

function follow(portal) {
  const sizes = new ResizeObserver(() => window.dispatchEvent(new Event("scroll")));
  const watch = () => portal.querySelectorAll(".q-menu").forEach((list) => sizes.observe(list));
  new MutationObserver(watch).observe(portal, { childList: true });
  watch();
}
