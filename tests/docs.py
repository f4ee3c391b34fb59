"""docs.py BUILD [--quick]: runs what the documents show.

Commands: each line of a ```sh block of README.md, CONTRIBUTING.md, docs/*.md and examples/*.md. A line that names
something of the tree (make, build/, examples/, ..) runs at the top of a copy of the tree, any other in an empty folder of
its document, with the library and the program installed. Each has to end with 0, or with 1 where its comment says "exit
status 1". tests/docs_skip.txt lists the lines that do not run here, with the reason; those that are slow run without --quick.
PYTHON: an interpreter with numpy and scipy; without it no Python is run.
Programs: ```python blocks of a document run one after the other; a ```c block stands in an example as it is.
Names: `make TARGET`, `delassus COMMAND --option` and `build/tests/..` in the text exist.
In the end `git status` of the copy is clean.
"""
import glob
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time

build = os.path.abspath(sys.argv[1])
quick = "--quick" in sys.argv
python = os.environ.get("PYTHON")
documents = ["README.md", "CONTRIBUTING.md"] + sorted(glob.glob("docs/*.md") + glob.glob("examples/*.md"))
OF_TREE = r"\s*([A-Z_0-9]+=\S+ )*(make|\.ci/|build/|examples/|docs/|python3 examples|cc examples|dpkg-|pip)"
failures = []


def skip(what):
    """Fails if NO_SKIP is set."""
    if subprocess.run(["tests/skip.sh", what]).returncode:
        failures.append(what)


if not os.path.exists(".git"):
    skip("commands of the documents, no git")
    sys.exit(len(failures))


def fail(where, what):
    failures.append(where)
    print(f"FAILED: {where}: {what}")


def read_skips():
    skips = {}
    for line in open("tests/docs_skip.txt"):
        if line.strip() and not line.startswith("#"):
            command, reason = line.rstrip("\n").split("  # ")
            skips[command.strip()] = reason
    return skips


def blocks(text):
    """Yields (line number, language, lines) of each fenced block."""
    language, lines = None, []
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("```"):
            if language is None:
                language, lines, start = line[3:].strip(), [], number + 1
            else:
                yield start, language, lines
                language = None
        elif language is not None:
            lines.append(line)
        elif re.match(r"    (make |build/|delassus [a-z]|cc |gfortran |pip |mpirun )", line):
            fail(f"line {number}", "a command outside of a ```sh block: " + line.strip())


def run(where, command, folder, environment, wanted=0, text=None):
    start = time.time()
    done = subprocess.run(command, shell=text is None, input=text, cwd=folder, env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != wanted:
        fail(where, f"exit status {done.returncode}: {command if text is None else 'python'}\n{done.stdout[-1500:]}")
    return time.time() - start


def copy_tree(to):
    """Copies what git knows or would add, so that changes that are not committed count, too."""
    files = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", "-z"], check=True,
                           stdout=subprocess.PIPE).stdout.decode().split("\0")
    files = [name for name in files if name and os.path.exists(name)]
    os.mkdir(to)
    pack = subprocess.Popen(["tar", "cf", "-", "--no-recursion", "--null", "-T", "-"], stdin=subprocess.PIPE,
                            stdout=subprocess.PIPE)
    unpack = subprocess.Popen(["tar", "xf", "-", "-C", to], stdin=pack.stdout)
    pack.stdin.write("\0".join(files).encode())
    pack.stdin.close()
    if unpack.wait() or pack.wait():
        sys.exit("check-docs: the tree cannot be copied")
    os.symlink(build, to + "/build")
    git = ["git", "-C", to, "-c", "user.name=docs", "-c", "user.email=docs@localhost"]
    subprocess.run(git + ["init", "-q"], check=True, stderr=subprocess.DEVNULL)
    with open(to + "/.git/info/exclude", "a") as exclude:
        exclude.write("/build\n")
    subprocess.run(git + ["add", "-A"], check=True)
    subprocess.run(git + ["commit", "-qm", "copy"], check=True)


def check_names(document, text, environment):
    """Looks up what the text names between backticks."""
    makefiles = open("Makefile").read() + open("src/mpi/mpi.mk").read()
    for code in re.findall(r"`([^`\n]+)`", text):
        make = re.match(r"make ((?:[A-Z_0-9]+=(?:'[^']*'|\"[^\"]*\"|\S*) ?)*)([a-z][a-z-]*)?", code)
        if make and make.group(2) and not re.search(rf"^[a-z -]*\b{make.group(2)}\b[a-z -]*:", makefiles, re.M):
            fail(document, f"no target: {code}")
        for test in re.findall(r"build/tests/[a-z/_]+", code):
            if not glob.glob(test[len("build/"):] + ".*"):
                fail(document, f"no test: {code}")
        program = re.match(r"(?:build/)?delassus ([a-z]+)(.*)", code)
        if program:
            words = helps.setdefault(program.group(1), subprocess.run(
                ["delassus", program.group(1), "--help"], env=environment, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, text=True).stdout)
            for option in re.findall(r" (--[a-z]+)", program.group(2)):
                if option + "=" not in words and not re.search(option + r"\b", words):
                    fail(document, f"no option: {code}")


helps = {}
with tempfile.TemporaryDirectory() as root:
    tree, installed = root + "/tree", root + "/installed"
    copy_tree(tree)
    subprocess.run(["make", "-s", "install", f"PREFIX={installed}", "V=0"], cwd=tree, check=True,
                   stdout=subprocess.DEVNULL)
    os.mkdir(root + "/tmp")
    if python:
        os.symlink(subprocess.run([python, "-c", "import sys; print(sys.executable)"], stdout=subprocess.PIPE,
                                  text=True).stdout.strip(), installed + "/bin/python3")
    environment = dict(os.environ, PATH=f"{installed}/bin:{os.environ['PATH']}", TMPDIR=root + "/tmp",
                       PKG_CONFIG_PATH=f"{installed}/lib/pkgconfig", LD_LIBRARY_PATH=f"{installed}/lib",
                       OPENBLAS_NUM_THREADS="1", PYTHONDONTWRITEBYTECODE="1",
                       PYTHONPATH=tree + "/src/python", DELASSUS_LIBRARY=f"{installed}/lib/libdelassus.so")
    examples = "".join(open(name).read() for name in glob.glob("examples/*.c"))
    skips, skipped, done, longest = read_skips(), set(), {}, []
    for document in documents:
        text = open(document).read()
        folder = f"{root}/own-{document.replace('/', '-')}"
        os.mkdir(folder)
        for name in glob.glob(f"{installed}/share/doc/delassus/examples/point.*") + [
                f"{installed}/share/doc/delassus/data"]:
            os.symlink(name, f"{folder}/{os.path.basename(name)}")
        program, is_new = "", False

        def run_program():
            imports = {"numpy"} | set(re.findall(r"\b(?:h5py|matplotlib)\b", program))
            missing = [name for name in sorted(imports) if not python or subprocess.run(
                [python, "-c", "import " + name], stderr=subprocess.DEVNULL).returncode]
            if missing:
                skip(f"program of {document}, no {missing[0]}")
            else:
                run(document, [python, "-"], folder, environment, text=program)

        for start, language, lines in blocks(text):
            if language == "python":
                program, is_new = program + "\n".join(lines) + "\n", True
            if language == "c" and "\n".join(lines) not in examples:
                fail(f"{document}:{start}", "this program is no example")
            if language != "sh":
                continue
            if is_new:
                run_program()
                is_new = False
            for number, line in enumerate(lines, start):
                command = line.split("  #")[0].strip()
                if not command:
                    continue
                if command in skips:
                    skipped.add(command)
                    if quick or not skips[command].startswith("slow"):
                        continue
                if "python3" in command and not python:
                    skip(f"{document}, no python3 with numpy and scipy")
                    continue
                place = tree if re.match(OF_TREE, command) else folder
                if done.setdefault((command, place), document) != document:
                    continue
                wanted = int("exit status 1" in line)
                longest.append((run(f"{document}:{number}", command, place, environment, wanted), command))
        if is_new:
            run_program()
        check_names(document, text, environment)
    for command in sorted(set(skips) - skipped):
        fail("tests/docs_skip.txt", f"no document has this line: {command}")
    status = subprocess.run(["git", "-C", tree, "status", "--porcelain"], stdout=subprocess.PIPE, text=True).stdout
    if status:
        fail("git status", "\n" + status)
for seconds, command in sorted(longest, reverse=True)[:5]:
    print(f"{seconds:6.1f} s  {command}")
print(f"docs: {len(longest)} commands of {len(documents)} documents run, {len(skipped)} are left out, "
      f"{len(failures)} failures; git status is {'not ' if status else ''}clean")
sys.exit(len(failures) > 0)
