"""search.py HTML: gives the guide that Doxygen wrote a search of its words: every section of every page goes into
HTML/words.js, which guide.js asks; each page gets the box, the style for narrow and dark screens, and its words back
where Doxygen shows entities in a tip. `make docs` runs it.
"""
import glob
import html
import json
import os
import re
import shutil
import sys

folder = sys.argv[1]
# lists of names, whose words stand on other pages
LISTS = re.compile(r"^(functions|globals|annotated|classes|files\.html|dir_|.*_8md\.html|index\.html|navtree|pages)")
sections = []


def words_of(text):
    text = re.sub(r'<(script|style|iframe).*?</\1>|<div class="(fragment )?toc">.*?</div>', " ", text, flags=re.S)
    return " ".join(html.unescape(re.sub(r"<[^>]*>", " ", text)).split())


def add(page, title, anchor, heading, text):
    if text or heading:
        sections.append([page + ("#" + anchor if anchor else ""), title, heading, text])


for path in sorted(glob.glob(folder + "/*.html")):
    page = os.path.basename(path)
    text = open(path).read()
    title = re.search(r"<title>delassus: (.*?)</title>", text)
    body = re.search(r'<div class="contents">(.*)<!-- start footer', text, re.S)
    if title and body and not LISTS.match(page) and "_source.html" not in page:
        title = words_of(title.group(1)).replace(" File Reference", "").replace("include/delassus/", "")
        # a chapter begins at a heading of a page of prose, or at a function of a header
        parts = re.split(r'<h\d>(?=<a class="anchor" id=)|<a id="(?=a[0-9a-f]{32}")', body.group(1))
        add(page, title, "", "", words_of(re.sub(r'<table class="memberdecls">.*?</table>', "", parts[0], flags=re.S)))
        for part in parts[1:]:
            anchor = re.match(r'(?:<a class="anchor" id=")?([^"]+)"', part).group(1)
            head, _, rest = re.sub(r"^[^>]*>(</a>)?", "", part, count=1).partition("</h")
            heading = words_of(re.sub(r'.*<span class="permalink">.*?</span>', "", head, flags=re.S))
            add(page, title, anchor, heading, words_of(rest.partition(">")[2]))
    text = re.sub(r"&amp;(#\d+;)", r"&\1", text)
    top = '<input id="guide-search" type="search" placeholder="Search the guide" aria-label="Search the guide"/>'
    text = text.replace('<div id="main-nav"></div>', '<button id="guide-fold" aria-label="Contents">&#9776;</button>' + top +
                        '<div id="guide-found"></div>\n<div id="main-nav"></div>')
    text = text.replace("</head>", '<script src="words.js" defer="defer"></script>'
                        '<script src="guide.js" defer="defer"></script>\n</head>')
    open(path, "w").write(text)
with open(folder + "/words.js", "w") as file:
    file.write("const guideWords = " + json.dumps(sections, ensure_ascii=False, separators=(",", ":")) + ";\n")
shutil.copy(os.path.dirname(os.path.abspath(__file__)) + "/guide.js", folder)
