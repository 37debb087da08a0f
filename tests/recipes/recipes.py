#!/usr/bin/env python3
"""Follows each row of "Where to add things" (README.md) in a copy of the tree, and builds what proves that the row is true.

    recipes.py --check    no build: every row has its recipe, each anchor is found once, and a recipe touches what its row names, no more
    recipes.py            the same, then one copy with all recipes: hoist-gen, the changed objects, the proofs, the console's types

A recipe is a file NAME.recipe; its first line is the row's first cell. Lines that begin with "@" say what the lines after them are:

    @ after FILE | ANCHOR     insert behind the one line that holds ANCHOR       @ before: in front of it
    @ instead FILE | ANCHOR   replace that line
    @ new FILE                a new file
    @ proof                   the body of a test, run in the copy
    @ include                 headers of that test
    @ run COMMAND             run in the copy; the lines below must be in its output
    @ expect FILE             the lines below must be in this file after hoist-gen has run
"""
import filecmp
import os
import re
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
TOP = os.path.dirname(os.path.dirname(HERE))
EDITS = ("after", "before", "instead", "new")


class Wrong(Exception):
    pass


class Recipe:
    def __init__(self, path):
        self.file = os.path.basename(path)
        self.parts = []
        with open(path, encoding="utf-8") as source:
            self.row = source.readline().strip()
            for line in source.read().splitlines():
                if line.startswith("@ "):
                    kind, _, rest = line[2:].partition(" ")
                    self.parts.append((kind, rest.strip(), []))
                elif self.parts:
                    self.parts[-1][2].append(line)
                elif line:
                    raise Wrong(f"{self.file}: text before the first @")

    def touched(self):
        return [rest.split(" | ")[0] for kind, rest, _ in self.parts if kind in EDITS]


def readme_rows():
    """First cell -> names in backticks of the other cells that say what to write."""
    rows = {}
    with open(os.path.join(TOP, "README.md"), encoding="utf-8") as source:
        section = source.read().split("## Where to add things")[1].split("\n## ")[0]
    for line in section.splitlines():
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if line.startswith("|") and len(cells) == 4 and not set(cells[0]) <= set("-") and cells[0] != "to add":
            rows[cells[0]] = [name for name in re.findall(r"`([^`]+)`", cells[1] + cells[2]) if re.search(r"[./]", name) and " " not in name]
    return rows


def names(name, path):
    return path == name or path.endswith("/" + name) or (name.endswith("/") and path.startswith(name))


def check(recipes):
    """The sentences about what is wrong with the recipes and the table, without building anything."""
    wrong = []
    rows = readme_rows()
    told = [recipe.row for recipe in recipes]
    wrong += [f"README.md: no recipe for: {row}" for row in rows if told.count(row) != 1]
    for recipe in recipes:
        if recipe.row not in rows:
            wrong.append(f"{recipe.file}: README.md has no row: {recipe.row}")
            continue
        paths = recipe.touched()
        for path in paths:
            if not any(names(name, path) for name in rows[recipe.row]):
                wrong.append(f"{recipe.file}: touches {path}, which its row does not name")
        for name in rows[recipe.row]:
            # A folder is a place to choose from.
            if not name.endswith("/") and not any(names(name, path) for path in paths):
                wrong.append(f"{recipe.file}: does not touch {name}, which its row names")
        if not any(kind in ("proof", "run", "expect") for kind, _, _ in recipe.parts):
            wrong.append(f"{recipe.file}: proves nothing")
    return wrong


def apply(recipe, top):
    for kind, rest, lines in recipe.parts:
        if kind not in EDITS:
            continue
        path, _, anchor = rest.partition(" | ")
        full = os.path.join(top, path)
        if kind == "new":
            if os.path.exists(full):
                raise Wrong(f"{recipe.file}: {path} exists already")
            os.makedirs(os.path.dirname(full), exist_ok=True)
            text = lines
        else:
            with open(full, encoding="utf-8") as source:
                text = source.read().splitlines()
            found = [at for at, line in enumerate(text) if anchor in line]
            if len(found) != 1:
                raise Wrong(f"{recipe.file}: {path}: {len(found)} lines hold: {anchor}")
            at = found[0]
            text[at + (kind == "after") : at + (kind != "before")] = lines
        with open(full, "w", encoding="utf-8") as target:
            target.write("\n".join(text).rstrip("\n") + "\n")


def tracked():
    listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=TOP, check=True, capture_output=True, text=True).stdout
    return [path for path in listed.split("\0") if path and os.path.isfile(os.path.join(TOP, path))]


def make_copy(recipes, top, only=None):
    """A copy with the recipes applied. Unchanged files keep their time and place, so that nothing is built twice."""
    fresh = top + ".new"
    shutil.rmtree(fresh, ignore_errors=True)
    for path in tracked() if only is None else only:
        os.makedirs(os.path.dirname(os.path.join(fresh, path)), exist_ok=True)
        shutil.copy2(os.path.join(TOP, path), os.path.join(fresh, path))
    for recipe in recipes:
        apply(recipe, fresh)
    if only is None:
        write_proofs(recipes, fresh)
        mirror(fresh, top)
    shutil.rmtree(fresh)


def all_files(top):
    for folder, folders, files in os.walk(top):
        folders[:] = [name for name in folders if os.path.join(folder, name) not in (os.path.join(top, "build"), os.path.join(top, "web/node_modules"))]
        for name in files:
            yield os.path.relpath(os.path.join(folder, name), top)


def mirror(source, target):
    """Makes `target` hold what `source` holds, and writes only files that differ."""
    wanted = set(all_files(source))
    for path in set(all_files(target)) - wanted:
        os.remove(os.path.join(target, path))
    for path in wanted:
        new, old = os.path.join(source, path), os.path.join(target, path)
        if os.path.isfile(old) and filecmp.cmp(new, old, shallow=False):
            continue
        os.makedirs(os.path.dirname(old), exist_ok=True)
        shutil.copyfile(new, old)
        shutil.copymode(new, old)


def write_proofs(recipes, top):
    includes, bodies = ["#include <gtest/gtest.h>"], []
    for recipe in recipes:
        for kind, _, lines in recipe.parts:
            if kind == "include":
                includes += [f"#include {line}" for line in lines if line and f"#include {line}" not in includes]
            elif kind == "proof":
                name = re.sub(r"[^A-Za-z]", "_", recipe.row.title())
                bodies += [f"TEST(Recipes, {name}) {{", *("  " + line for line in lines if line), "}"]
    with open(os.path.join(top, "tests/recipes/proofs.cpp"), "w", encoding="utf-8") as target:
        target.write("\n".join([*includes, "namespace hoist {", *bodies, "}  // namespace hoist", ""]))
    with open(os.path.join(top, "tests/CMakeLists.txt"), "a", encoding="utf-8") as target:
        # Of the server only the changed sources are compiled, and each by itself takes less than with the eleven others that it is joined with.
        target.write("set_target_properties(hoist_server PROPERTIES UNITY_BUILD OFF)\n"
                     "add_executable(recipe_proofs recipes/proofs.cpp)\n"
                     "target_link_libraries(recipe_proofs PRIVATE hoist_core hoist_publish hoist_server_contract hoist_db GTest::gtest_main)\n")


def run(command, top, what):
    print(f"recipes: {what}", flush=True)
    result = subprocess.run(command, cwd=top, capture_output=True, text=True, shell=isinstance(command, str))
    if result.returncode != 0:
        raise Wrong(f"{what} failed:\n{(result.stdout + result.stderr)[-6000:]}")
    return result.stdout + result.stderr


def objects_of(recipes, top):
    """Of each changed or new source: the object with it. Libraries and programs with them would build the whole tree."""
    changed = {path for recipe in recipes for path in recipe.touched() if path.endswith(".cpp")}
    build = os.path.join(top, "build")
    holds = {}  # a source -> the object of the target of its area; the mutants' programs compile some again
    with open(os.path.join(build, "build.ninja"), encoding="utf-8") as ninja:
        for made, source in re.findall(r"^build (\S+\.o): CXX_COMPILER\S* (\S+)", ninja.read(), re.MULTILINE):
            sources = [os.path.normpath(os.path.join(build, source))]
            if os.path.basename(source).startswith("unity_"):
                with open(sources[0], encoding="utf-8") as joined:
                    sources = re.findall(r'^#include "(.+)"', joined.read(), re.MULTILINE)
            area = os.path.join(top, made.split("/CMakeFiles/")[0], "")
            holds.update((part, made) for part in sources if part.startswith(area))
    for path in sorted(changed):
        if os.path.join(top, path) not in holds:
            raise Wrong(f"{path}: no target compiles it")
    return sorted({holds[os.path.join(top, path)] for path in changed})


def prove(recipes, top):
    build = os.path.join(top, "build")
    jobs = str(max(1, os.cpu_count() or 1))
    ninja = ["nice", "ninja", "-C", "build", "-k", "0", "-j", jobs]
    # Nothing of it runs for long. clang compiles it in about half of g++'s time (build_watched in deploy/lib/common.sh).
    compiler = ["-DCMAKE_CXX_COMPILER=clang++", "-DCMAKE_CXX_FLAGS=-w"] if shutil.which("clang++") else []
    options = ["-DCMAKE_BUILD_TYPE=Debug", "-DCMAKE_CXX_FLAGS_DEBUG=-O0", *compiler]
    run(["cmake", "-S", ".", "-B", "build", "-G", "Ninja", *options], top, "configuring the copy")
    run([*ninja, "hoist-gen"], top, "building hoist-gen")
    run(["build/bin/hoist-gen", "--top", top], top, "writing the generated files")
    run([*ninja, "recipe_proofs", "hoist-sim", *objects_of(recipes, top)], top, "building what the recipes changed")
    run(["build/bin/recipe_proofs"], top, "running the proofs")
    modules = os.path.join(TOP, "web/node_modules")
    if not os.path.isdir(modules):
        raise Wrong("web/node_modules is missing: npm ci in web/")
    if not os.path.exists(os.path.join(top, "web/node_modules")):
        os.symlink(modules, os.path.join(top, "web/node_modules"))
    for recipe in recipes:
        for kind, rest, lines in recipe.parts:
            wanted = [line for line in lines if line]
            if kind == "expect":
                with open(os.path.join(top, rest), encoding="utf-8") as source:
                    text = source.read()
            elif kind == "run":
                text = run(rest, top, rest)
            else:
                continue
            for line in wanted:
                if line not in text:
                    raise Wrong(f"{recipe.file}: not in {rest}: {line}")
    run(["web/node_modules/.bin/tsc", "--noEmit", "-p", "web"], top, "checking the console's types")


def main():
    recipes = [Recipe(os.path.join(HERE, name)) for name in sorted(os.listdir(HERE)) if name.endswith(".recipe")]
    order = list(readme_rows())
    recipes.sort(key=lambda recipe: order.index(recipe.row) if recipe.row in order else len(order))
    wrong = check(recipes)
    top = os.path.join(TOP, "build", "recipes")
    try:
        if "--check" in sys.argv:
            # An edited file of the tree is enough to see whether each anchor is found once.
            with tempfile.TemporaryDirectory() as folder:
                make_copy(recipes, os.path.join(folder, "copy"), sorted({path for recipe in recipes for path in recipe.touched() if os.path.isfile(os.path.join(TOP, path))}))
        elif not wrong:
            make_copy(recipes, top)
            prove(recipes, top)
    except Wrong as error:
        wrong.append(str(error))
    print("\n".join(wrong) if wrong else f"recipes: {len(recipes)} rows of README.md are true")
    return 1 if wrong else 0


sys.exit(main())
