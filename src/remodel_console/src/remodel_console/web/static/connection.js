// What a page does about a console that is away: it says so, and finds it soon when it comes again.
function watchConnection() {
  const manager = window.socket.io;
  manager.reconnectionDelay(250); // [ms]
  manager.reconnectionDelayMax(500); // [ms] else it grows, and a page would show old things for seconds
  manager.randomizationFactor(0);
  const [what, meaning] = document.querySelectorAll("#popup > span");
  what.textContent = "The console is away:";
  meaning.textContent = "what you see is old, and nothing can be commanded. To have it back: rosrun remodel_console console";
}
