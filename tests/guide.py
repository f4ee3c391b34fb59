"""guide.py HTML [BUILD]: every public function has a place in the guide, with words, and its search finds it.

Public: what the headers declare with DLS_API and, with BUILD, what the shared libraries export. The search is the one
of the browser: search/functions_*.js, whose entries lead to an anchor of a page. Where there is Chromium, its search
is asked for each name, too.
"""
import glob
import json
import os
import re
import shutil
import subprocess
import sys

html = sys.argv[1]
names = set()
for header in glob.glob("include/delassus/*.h"):
    names |= set(re.findall(r"DLS_API[^;{]*?\b(dls_[a-z0-9_A-Z]+)\(", open(header).read()))
for library in glob.glob(sys.argv[2] + "/libdelassus*.so") if len(sys.argv) > 2 else []:
    exported = subprocess.run(["nm", "-D", "--defined-only", library], check=True, stdout=subprocess.PIPE,
                              text=True).stdout
    names |= set(re.findall(r" T (dls_\w+)", exported))
index = {}
for script in glob.glob(html + "/search/functions_*.js"):
    for name, place in re.findall(r"\['(dls_\w+)',\['\.\./([^']+)'", open(script).read()):
        index[name] = place
pages, bad = {}, 0
for name in sorted(names):
    page, _, anchor = index.get(name, "").partition("#")
    if page and page not in pages:
        pages[page] = open(f"{html}/{page}").read()
    text = pages.get(page, "")
    at = text.find(f'id="{anchor}"') if anchor else -1
    # a member reaches to the anchor of the next one; its words stand in its memdoc
    member = text[at:].split('<a id="', 1)[0] if at >= 0 else ""
    words = re.search(r'<div class="memdoc">(.*?)</div>', member, re.S)
    found = words and len(re.sub(r"<.*?>|\s", "", words.group(1))) > 10
    if not found:
        bad += 1
        print(f"guide: {name}: " + ("no words" if at >= 0 else "the search does not find it"))


def ask_browser(browser):
    """Returns how many names the page of results shows in a browser, for each typed into its search."""
    sections = open(html + "/search/searchdata.js").read()
    letters = re.search(r'0: "([^"]*)"', sections).group(1)
    page = open(f"{html}/search/all_{letters.index('d'):x}.html").read()
    ask = """<script>var found = 0;
for (const name of %s) {
  searchResults.Search(name);
  const rows = [...document.getElementsByClassName("SRResult")].filter(row => row.style.display == "block");
  if (rows.some(row => row.getElementsByTagName("a")[0].textContent == name &&
                       row.getElementsByTagName("a")[0].href.includes(".html#"))) found++;
}
document.title = "found " + found;</script></body>""" % json.dumps(sorted(names))
    path = os.path.abspath(html + "/search/ask.html")
    with open(path, "w") as file:
        file.write(page.replace("</body>", ask))
    dom = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", "file://" + path],
                         stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=120).stdout
    os.remove(path)
    return int((re.search(r"<title>found (\d+)", dom) or [0, -1])[1])


browser = shutil.which("chromium")
if browser:
    found = ask_browser(browser)
    print(f"guide: in headless Chromium the search shows {found} of {len(names)}")
    bad += found != len(names)
print(f"guide: {len(names) - bad} of {len(names)} public functions have a place that the search finds")
sys.exit(bad > 0)
