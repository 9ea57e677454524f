// Draws attention to what waits for a person: badge, title of the tab, notification, sound.
const HEIGHT_HZ = 660, LENGTH_S = 0.35;

function beep() {
  const audio = new AudioContext();
  const tone = audio.createOscillator(), volume = audio.createGain();
  tone.frequency.value = HEIGHT_HZ;
  volume.gain.setValueAtTime(0.2, audio.currentTime);
  volume.gain.exponentialRampToValueAtTime(0.001, audio.currentTime + LENGTH_S);
  tone.connect(volume).connect(audio.destination);
  tone.start();
  tone.stop(audio.currentTime + LENGTH_S);
  tone.onended = () => audio.close();
}

export default {
  template: `<button v-show="waiting.length" type="button" class="inbox-badge" @click="goThere">{{ waiting.length }} waiting</button>`,
  props: { title: String, waiting: Array, notify: Boolean, sound: Boolean },
  mounted() {
    this.known = [];
    this.onVisibility = () => this.$emit("hidden", document.hidden);
    document.addEventListener("visibilitychange", this.onVisibility);
    if (document.hidden) this.onVisibility();
    this.show();
  },
  unmounted() {
    document.removeEventListener("visibilitychange", this.onVisibility);
  },
  watch: {
    waiting() {
      this.show();
    },
  },
  methods: {
    show() {
      document.title = this.waiting.length ? `(${this.waiting.length}) ${this.title}` : this.title;
      const fresh = this.waiting.filter((text) => !this.known.includes(text));
      this.known = [...this.waiting];
      if (!this.waiting.length) document.body.classList.remove("whole-page");
      if (!fresh.length) return;
      if (this.sound) beep();
      if (this.notify && window.Notification?.permission === "granted") {
        const shown = new Notification("REMODEL is waiting for you", { body: fresh.join("\n"), tag: "remodel" });
        shown.onclick = () => {
          window.focus();
          this.goThere();
        };
      }
    },
    askPermission() {
      window.Notification?.requestPermission();
    },
    goThere() {
      document.body.classList.remove("whole-page");
      document.querySelector(".inbox input, .inbox .q-btn:not([disabled])")?.focus();
    },
  },
};
