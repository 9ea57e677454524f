// The last lines of the log, filtered. Text is only ever set as text.
const KEPT = 500;
const SEVERITIES = ["error", "warning", "hint", "info", "debug"];

export default {
  template: `
    <div class="log-pane">
      <div class="log-tools">
        <span class="log-levels" role="group" aria-label="Severities shown">
          <button v-for="one in severities" :key="one" type="button" :aria-pressed="String(!left[one])" @click="toggle(one)">{{ one }}</button>
        </span>
        <input ref="word" type="search" placeholder="Find in the log" aria-label="Find in the log" @input="filter">
        <a href="/log.txt" download>Export</a>
        <span ref="count" class="soft" role="status"></span>
      </div>
      <div ref="lines" class="log" role="log" tabindex="0" aria-label="Log"></div>
    </div>`,
  data: () => ({ severities: SEVERITIES, left: {} }), // left: severities that are left out
  methods: {
    toggle(severity) {
      this.left[severity] = !this.left[severity];
      this.filter();
    },
    add(lines) {
      const pane = this.$refs.lines;
      const isAtEnd = pane.scrollHeight - pane.scrollTop - pane.clientHeight < 30;
      for (const [time, severity, text] of lines.slice(-KEPT)) {
        const line = document.createElement("div");
        line.className = `line ${severity}`;
        line.dataset.severity = severity;
        for (const [name, content] of [["time", time], ["severity", severity], ["text", text]]) {
          const part = document.createElement("span");
          part.className = name;
          part.textContent = content;
          line.append(part);
        }
        line.hidden = !this.isWanted(line);
        pane.append(line);
      }
      while (pane.childElementCount > KEPT) pane.firstElementChild.remove();
      this.countLines();
      if (isAtEnd) pane.scrollTop = pane.scrollHeight;
    },
    isWanted(line) {
      const word = this.$refs.word.value.trim().toLowerCase();
      return !this.left[line.dataset.severity] && line.querySelector(".text").textContent.toLowerCase().includes(word);
    },
    filter() {
      for (const line of this.$refs.lines.children) line.hidden = !this.isWanted(line);
      this.countLines();
      this.$refs.lines.scrollTop = this.$refs.lines.scrollHeight;
    },
    countLines() {
      const all = this.$refs.lines.childElementCount;
      const shown = this.$refs.lines.querySelectorAll(".line:not([hidden])").length;
      this.$refs.count.textContent = shown === all ? "" : `${shown} of ${all} lines`;
    },
  },
};
