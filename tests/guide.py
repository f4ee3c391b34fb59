"""guide.py HTML [BUILD]: every public function has a place in the guide, with words, and the search of the guide finds it
first; so it does the pages of some words that are no names.

Public: what the headers declare with DLS_API and, with BUILD, what the shared libraries export. Where there is Chromium,
names and words are typed into the box of a page, and a narrow screen hides the side bar.
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
# what users ask for that is no name of the library, and the page that answers
WORDS = {"lemke": "lcp_8h", "tolerance": "md_docs_choosing", "jam": "md_docs_choosing", "jammed": "md_docs_choosing",
         "Matrix Market": "md_docs_files", "calculix": "md_docs_files", "restitution": "md_docs_motion",
         "arch": "md_docs_limit", "certificate": "md_docs_certificate", "threads": "md_docs_threads",
         "mortar": "md_docs_contacts", "mujoco": "md_docs_stick", "weighted reactions": "md_docs_jean"}
sections = json.loads(open(html + "/words.js").read().partition(" = ")[2].rstrip().rstrip(";"))
index = {heading[:-2]: place for place, _, heading, _ in sections if heading.endswith("()")}
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


for place in {place.partition("#")[0] for place, *_ in sections}:
    if "&amp;#" in open(f"{html}/{place}").read():
        bad += 1
        print(f"guide: {place} shows an entity")


def ask_browser(browser, script, *options):
    """Returns the title that the script gives the first page of the guide once it is loaded."""
    path = os.path.abspath(html + "/ask.html")
    with open(path, "w") as file:
        file.write(open(html + "/index.html").read().replace("</body>", "<script>addEventListener('load', () => {" +
                                                            script + "});</script></body>"))
    dom = subprocess.run([browser, "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom", *options,
                          "file://" + path],
                         stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, timeout=120).stdout
    os.remove(path)
    return (re.search(r"<title>(.*?)</title>", dom) or ["", "no answer"])[1]


browser = shutil.which("chromium")
if browser:
    asked = {**{name: index.get(name, "nowhere") for name in names}, **WORDS}
    missed = ask_browser(browser, """const box = document.getElementById("guide-search"), missed = [];
for (const [question, page] of Object.entries(%s)) {
  box.value = question;
  box.dispatchEvent(new Event("input"));
  const first = document.querySelector("#guide-found a");
  if (!first || !first.getAttribute("href").startsWith(page)) missed.push(question);
}
document.title = "missed: " + missed.join(", ");""" % json.dumps(asked))
    print(f"guide: {len(asked)} names and words typed into its search, {missed}")
    side = ask_browser(browser, "document.title = getComputedStyle(document.getElementById('side-nav')).display",
                       "--window-size=500,800")
    print(f"guide: on a narrow screen the side bar is {side}")
    bad += (missed != "missed: ") + (side != "none")
else:
    bad += subprocess.run(["tests/skip.sh", "the search in a browser, no chromium"]).returncode
print(f"guide: {len(names) - bad} of {len(names)} public functions have a place that the search finds")
sys.exit(bad > 0)
