"""links.py FOLDER [INCLUDE]: names each dead link and dead file name of the documents in a folder.

Of *.md: the targets of links, with their anchors, and the file names in the text (with a slash, or *.md), which are
looked up beside the document, from the folder, and in INCLUDE. In the tree also marks of docs/ that installed.awk would
not see. Of *.html: href and src, with their anchors.
Without INCLUDE the folder is the source tree, of which git names the documents.
"""
import os
import re
import subprocess
import sys
import urllib.parse

folder = sys.argv[1]
include = sys.argv[2] if len(sys.argv) > 2 else None
ENDINGS = "md|c|h|hpp|cpp|f90|py|ipynb|sh|txt|png|svg|csv|hdf5|mtx|awk|gp"
dead, seen = [], 0
anchors_of = {}


def slug(heading):
    heading = re.sub(r"[`*]|\[([^]]*)\]\([^)]*\)", lambda m: m.group(1) or "", heading.strip().lower())
    return re.sub(r"[^\w\- ]", "", heading).replace(" ", "-")


def anchors(path):
    if path not in anchors_of:
        text = open(path, errors="replace").read()
        if path.endswith(".md"):
            anchors_of[path] = {slug(line.lstrip("#")) for line in re.findall(r"^#+ .*", text, re.M)}
        else:
            anchors_of[path] = set(re.findall(r"""(?:id|name)=["']([^"']*)["']""", text))
    return anchors_of[path]


def look(document, target, places):
    """Counts the target, and notes it if it leads nowhere."""
    global seen
    seen += 1
    path, _, anchor = target.partition("#")
    path = urllib.parse.unquote(path)
    found = [p for p in (os.path.join(place, path) for place in places) if os.path.exists(p)] if path else [document]
    if not found:
        dead.append(f"{document}: {target}")
    elif anchor and os.path.isfile(found[0]) and urllib.parse.unquote(anchor) not in anchors(found[0]):
        dead.append(f"{document}: {target}: no such anchor")


def look_markdown(document):
    here = os.path.dirname(document)
    text = open(document).read()
    if document.startswith(os.path.join(folder, "docs")) and not include:
        marks = re.findall(r"<!--.*?-->|<!--", text, re.S)
        if marks != ["<!-- tree -->", "<!-- /tree -->"] * (len(marks) // 2):
            dead.append(f"{document}: <!-- tree --> and <!-- /tree --> do not alternate, each in one line")
    for target in re.findall(r"\]\(([^)\s]+)\)", re.sub(r"```.*?```|`[^`\n]*`", "", text, flags=re.S)):
        if not re.match(r"[a-z]+:", target):
            look(document, target, [here])
    prose = re.sub(r"\[[^]]*\]\([^)\s]+\)|https?://\S+|```.*?```", " ", text, flags=re.S)
    places = [here, folder] + ([include] if include else [os.path.join(folder, "include"), os.path.join(folder, "src")])
    for name in re.findall(rf"(?<![\w./*<-])((?:\.\./|\./)?\w[\w./-]*\.(?:{ENDINGS}))(?![\w*])", prose):
        if ("/" in name or name.endswith(".md")) and not re.search(r"^(build|usr|tmp)/|NAME|mine\.c", name):
            look(document, name, places)


def look_html(document):
    here = os.path.dirname(document)
    text = re.sub(r"<script.*?</script>", "", open(document, errors="replace").read(), flags=re.S)
    for target in re.findall(r"""(?:href|src)=["']([^"']+)["']""", text):
        if not re.match(r"[a-z]+:|//", target):
            look(document, target.replace("&amp;", "&"), [here])


if include or not os.path.exists(folder + "/.git"):
    names = [os.path.join(at, name) for at, _, files in os.walk(folder) for name in files]
else:
    names = subprocess.run(["git", "-C", folder, "ls-files", "-co", "--exclude-standard", "*.md"], check=True,
                           stdout=subprocess.PIPE, text=True).stdout.split()
    names = [os.path.join(folder, name) for name in names if os.path.exists(os.path.join(folder, name))]
for name in sorted(names):
    if name.endswith(".md"):
        look_markdown(name)
    elif name.endswith(".html"):
        look_html(name)
for line in dead:
    print("dead: " + line)
print(f"links: {seen} of {sum(name.endswith(('.md', '.html')) for name in names)} documents, {len(dead)} dead")
sys.exit(len(dead) > 0)
