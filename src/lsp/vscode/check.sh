#!/bin/bash
# Tests the extension with `npm test` and packs it as admire-adams.vsix. Needs `admire`: ADMIRE, or target/debug/admire.
# Prints SKIPPED where there is no Node or npm, or where the packages cannot be installed.
set -euo pipefail
cd "$(dirname "$0")"
if ! command -v npm >/dev/null || ! node -e 'process.exit(parseInt(process.version.slice(1)) < 20 ? 1 : 0)'; then
    echo "SKIPPED: the extension for Visual Studio Code: there is no Node 20 with npm here"
    exit 0
fi
if ! cmp -s package-lock.json node_modules/installed && ! {
    npm ci --ignore-scripts --prefer-offline --no-audit --no-fund --loglevel=error && cp package-lock.json node_modules/installed
}; then
    echo "SKIPPED: the extension for Visual Studio Code: its packages cannot be installed here"
    exit 0
fi
npm test
npm run package
