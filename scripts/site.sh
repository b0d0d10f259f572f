#!/usr/bin/env bash
# Builds the site of the documents: docs/ as an mdBook with search, in out/site. Then looks for links and anchors of its
# pages that lead nowhere.
#
#   scripts/site.sh            needs mdbook 0.5: cargo install mdbook --locked
#
# MDBOOK names the program, else it is found on the path. Exit status: 0; 1 where a link leads nowhere; 2 for an error.
set -euo pipefail
case ${1-} in -h | --help) sed -n '2,/^set /s/^# \{0,1\}//p' "$0"; exit 0 ;; esac
[ $# = 0 ] || { sed -n '2,/^set /s/^# \{0,1\}//p' "$0" >&2; exit 2; }
cd "$(dirname "$0")/.."
fail() { echo "site: $*" >&2; exit 2; }
mdbook=$(command -v "${MDBOOK:-$(PATH=$PATH:${CARGO_HOME:-$HOME/.cargo}/bin command -v mdbook || echo mdbook)}") ||
  fail "mdbook is missing: cargo install mdbook --locked"
rm -rf out/site
"$mdbook" build >out/site.log 2>&1 || { cat out/site.log >&2; fail "mdbook does not build the site"; }
python3 - <<'PYTHON'
import html.parser, pathlib, sys, urllib.parse

class Page(html.parser.HTMLParser):
    def __init__(self, path):
        super().__init__()
        self.ids, self.links = set(), []
        self.feed(path.read_text())

    def handle_starttag(self, _, attributes):
        for name, value in attributes:
            if name == "id":
                self.ids.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)

root = pathlib.Path("out/site").resolve()
pages = {path: Page(path) for path in root.rglob("*.html") if path.name not in ("print.html", "404.html", "toc.html")}
broken, links = [], 0
for path, page in pages.items():
    for link in page.links:
        url = urllib.parse.urlsplit(link)
        if url.scheme or url.netloc:
            continue
        links += 1
        target = (path.parent / urllib.parse.unquote(url.path)).resolve() if url.path else path
        if target.is_dir():
            target /= "index.html"
        if not target.is_file() or root not in target.parents:
            broken.append(f"{path.relative_to(root)}: {link}: there is no such file in the site")
        elif url.fragment and target in pages and urllib.parse.unquote(url.fragment) not in pages[target].ids:
            broken.append(f"{path.relative_to(root)}: {link}: there is no such place")
print("\n".join(["site: " + line for line in broken]), end="\n" if broken else "", file=sys.stderr)
print(f"site: {len(pages)} pages, {links} links, {len(broken)} broken: out/site/index.html", file=sys.stderr)
sys.exit(1 if broken else 0)
PYTHON
