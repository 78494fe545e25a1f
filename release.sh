#!/usr/bin/env bash
# Builds wheel and sdist into dist/, and installs and runs each in a bare environment. Uploads nothing.
set -euo pipefail
cd "$(dirname "$0")"
version=$(sed -n 's/^version = "\(.*\)"/\1/p' pyproject.toml)
stop() { echo "release: $1" >&2; exit 1; }

[ -z "$(git status --porcelain)" ] || stop "there are changes that are not committed"
grep -q "^## \[$version\]" CHANGELOG.md || stop "CHANGELOG.md has no section [$version]"
grep -q "^version: $version$" CITATION.cff || stop "CITATION.cff states another version than $version"
grep -q "version = {$version}" docs/cite.md || stop "docs/cite.md states another version than $version"

rm -rf dist
.venv/bin/python -m build --outdir dist .
bare=$(mktemp -d)
trap 'rm -rf "$bare"' EXIT
for file in dist/*.whl dist/*.tar.gz; do
  rm -rf "$bare/venv"
  "${PYTHON:-python3.11}" -m venv "$bare/venv"
  "$bare/venv/bin/pip" install --quiet "$file"
  [[ "$(cd "$bare" && venv/bin/topple --version)" = "topple $version, "* ]] || stop "$file installs another version"
  (cd "$bare" && venv/bin/topple --completion bash >/dev/null && venv/bin/topple demo tower --seed 0)
  echo "$file: installed and run"
done
ls -l dist
