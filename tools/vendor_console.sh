#!/usr/bin/env bash
# Copy the JavaScript libraries of the console from npm into its static files, with their licences. Needs npm; run it to change a version.
set -euo pipefail
CYTOSCAPE=3.34.4
ELKJS=0.12.1
target=$(cd "$(dirname "$0")/.." && pwd)/src/remodel_console/src/remodel_console/web/static/vendor
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm pack --silent "cytoscape@$CYTOSCAPE" "elkjs@$ELKJS" >/dev/null
for package in cytoscape elkjs; do
  mkdir "$package"
  tar xzf "$package"-*.tgz -C "$package" --strip-components 1
done
rm -rf "$target"
install -Dm644 cytoscape/dist/cytoscape.esm.min.mjs "$target/cytoscape.esm.min.mjs"
install -Dm644 cytoscape/LICENSE "$target/cytoscape.LICENSE"
install -Dm644 elkjs/lib/elk-api.js "$target/elk-api.js"
install -Dm644 elkjs/lib/elk-worker.min.js "$target/elk-worker.min.js"
install -Dm644 elkjs/LICENSE.md "$target/elkjs.LICENSE.md"
cat >"$target/README.md" <<EOF
Copied from npm by \`tools/vendor_console.sh\`; do not edit.

| package | version | licence | files |
|---|---|---|---|
| [cytoscape](https://js.cytoscape.org) | $CYTOSCAPE | MIT | cytoscape.esm.min.mjs |
| [elkjs](https://github.com/kieler/elkjs) | $ELKJS | EPL-2.0 | elk-api.js, elk-worker.min.js |
EOF
