// The picture of a camera. A new one is shown once it is here; those that came meanwhile are not asked for.
export default {
  template: `<figure class="camera"><img v-show="shown" :src="shown" :alt="label"><div v-show="!shown" class="none">{{ none }}</div>
    <figcaption>{{ label }}</figcaption></figure>`,
  props: { label: String, none: String },
  data: () => ({ shown: "" }),
  methods: {
    show(address) {
      this.wanted = address;
      if (!this.loading) this.load();
    },
    load() {
      const address = this.wanted;
      if (!address) {
        this.shown = "";
        return;
      }
      const image = new Image();
      this.loading = true;
      const done = () => {
        this.loading = false;
        if (this.wanted !== address) this.load();
      };
      image.onload = () => {
        this.shown = address;
        done();
      };
      image.onerror = done;
      image.src = address;
    },
  },
};
