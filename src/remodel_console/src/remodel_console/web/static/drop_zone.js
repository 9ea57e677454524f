// A place to drop a file on, or to choose one; it is sent as the body of one request.
export default {
  template: `<div class="drop-zone" :class="{ over }" @dragover.prevent="over = enabled" @dragleave="over = false" @drop.prevent="drop">
    <label class="drop-words"><input ref="file" type="file" :disabled="!enabled || sent !== null" @change="choose">
    <span>{{ sent === null ? words : "Sending " + sent + " %" }}</span></label></div>`,
  props: { address: String, words: String, enabled: Boolean },
  data: () => ({ over: false, sent: null }),
  methods: {
    drop(event) {
      this.over = false;
      this.send([...event.dataTransfer.files]);
    },
    choose(event) {
      this.send([...event.target.files]);
    },
    send(files) {
      if (!this.enabled || this.sent !== null || !files.length) return;
      if (files.length > 1) return this.$emit("refused", "Drop one file at a time.");
      const request = new XMLHttpRequest();
      request.open("POST", `${this.address}?name=${encodeURIComponent(files[0].name)}`);
      request.upload.onprogress = (event) => {
        this.sent = Math.round((100 * event.loaded) / Math.max(1, event.total));
      };
      request.onloadend = () => {
        this.sent = null;
        this.$refs.file.value = "";
        if (request.status === 200) this.$emit("sent", request.responseText);
        else this.$emit("refused", request.responseText || "The connection broke; drop the file again.");
      };
      this.sent = 0;
      request.send(files[0]);
    },
  },
};
