// The last lines of the log. Text is only ever set as text.
const KEPT = 500;

export default {
  template: `<div class="log" role="log" tabindex="0" aria-label="Log"></div>`,
  methods: {
    add(lines) {
      const pane = this.$el;
      const isAtEnd = pane.scrollHeight - pane.scrollTop - pane.clientHeight < 30;
      for (const [time, severity, text] of lines.slice(-KEPT)) {
        const line = document.createElement("div");
        line.className = `line ${severity}`;
        for (const [name, content] of [["time", time], ["severity", severity], ["text", text]]) {
          const part = document.createElement("span");
          part.className = name;
          part.textContent = content;
          line.append(part);
        }
        pane.append(line);
      }
      while (pane.childElementCount > KEPT) pane.firstElementChild.remove();
      if (isAtEnd) pane.scrollTop = pane.scrollHeight;
    },
  },
};
