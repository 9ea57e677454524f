// What a page does while the console does not answer: it shows that, and reconnects soon after a restart.
const SILENCE_MS = 5000; // the console pings every 2 s; one that is only stalled keeps its connection longer

function watchConnection() {
  const manager = window.socket.io;
  manager.reconnectionDelay(250); // [ms]
  manager.reconnectionDelayMax(500); // [ms] without it the delay grows, and a page would show old contents for seconds
  manager.randomizationFactor(0);
  const popup = document.getElementById("popup");
  const [what, meaning] = popup.querySelectorAll(":scope > span");
  what.textContent = "The console does not answer:";
  meaning.textContent = "the page shows old contents, and accepts no commands. If it is not running, start it with: rosrun remodel_console console";
  let heardMs = Date.now();
  manager.on("open", () => (heardMs = Date.now()));
  manager.on("ping", () => {
    heardMs = Date.now();
    popup.ariaHidden = window.socket.connected ? "true" : "false";
  });
  setInterval(() => {
    if (Date.now() - heardMs > SILENCE_MS) popup.ariaHidden = "false";
  }, 500);
}
