// What a page does while the console is not running: it shows that, and reconnects soon after its restart.
function watchConnection() {
  const manager = window.socket.io;
  manager.reconnectionDelay(250); // [ms]
  manager.reconnectionDelayMax(500); // [ms] without it the delay grows, and a page would show old contents for seconds
  manager.randomizationFactor(0);
  const [what, meaning] = document.querySelectorAll("#popup > span");
  what.textContent = "The console is not running:";
  meaning.textContent = "the page shows old contents, and accepts no commands. Start it with: rosrun remodel_console console";
}
