#!/usr/bin/env bash
# Makes the two libraries that the cockpit's page brings with it, each one file that browsers read as a module. For developers, once a release:
# the files are committed, so that nobody else needs Node or a network. Needs npm.
set -euo pipefail
cd "$(dirname "$0")/.."
THREE=0.187.0 UPLOT=1.6.32 ESBUILD=0.28.2
page=$PWD/src/polydraulic/cockpit/page
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
echo '{"private": true}' > package.json  # without it npm installs into a folder above
npm install --silent --no-audit --no-fund --ignore-scripts "three@$THREE" "uplot@$UPLOT" "esbuild@$ESBUILD"
cat > three.js <<'EOF'
export {
  BufferGeometry, Color, CylinderGeometry, DirectionalLight, EdgesGeometry, ExtrudeGeometry, Float32BufferAttribute,
  Group, HemisphereLight, Line, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, PCFShadowMap, PerspectiveCamera, PlaneGeometry, Scene, Shape, SphereGeometry, Vector3,
  WebGLRenderer,
} from "three";
EOF
echo 'export { default } from "uplot";' > uplot.js
for name in three uplot; do
  node_modules/.bin/esbuild "$name.js" --bundle --format=esm --minify --legal-comments=none --target=es2022 --outfile="$page/$name.js" \
    --banner:js="/* $name $(node -p "require('./node_modules/$name/package.json').version"), licence in LICENSE-$name.txt; made by tools/vendor_page.sh */"
  cp "node_modules/$name/LICENSE" "$page/LICENSE-$name.txt"
done
cp node_modules/uplot/dist/uPlot.min.css "$page/uplot.css"
