#!/usr/bin/python3
"""mutate.py TOP OUT LIST FOLDER...: copies the C++ files of the folders (relative to TOP) to OUT, with a switch at every operator, constant and
remembering statement inside functions. A program built of the copies runs as before, until a test program chooses one mutant (mutant_switch.hpp).
LIST gets one line for each mutant: number, file, line, what changes, and the source line, separated by tabs.

One build serves all mutants. clang reads the sources, so that types and templates are known; nothing is guessed from text but the operator
between two operands."""
import collections
import pathlib
import re
import sys

import clang.cindex as ci
from clang.cindex import CursorKind as Kind, TypeKind

MOST = 20000  # kMost of mutant_switch.hpp
WHOLE = {TypeKind.INT, TypeKind.UINT, TypeKind.SHORT, TypeKind.USHORT, TypeKind.LONG, TypeKind.ULONG, TypeKind.LONGLONG, TypeKind.ULONGLONG,
         TypeKind.SCHAR, TypeKind.UCHAR, TypeKind.CHAR_S}
REAL = {TypeKind.FLOAT, TypeKind.DOUBLE}
COMPARED = {'<': ('less', '>=', '<='), '>': ('more', '<=', '>='), '<=': ('most', '>', '<'), '>=': ('least', '<', '>'),
            '==': ('same', '!=', None), '!=': ('other', '==', None)}
COUNTED = {'+': ('sum', '-'), '-': ('difference', '+'), '*': ('product', '+'), '/': ('quotient', '*'), '&': ('bits_of_both', '|'),
           '|': ('bits_of_either', '&')}
FUNCTIONS = {Kind.FUNCTION_DECL, Kind.CXX_METHOD, Kind.CONSTRUCTOR, Kind.DESTRUCTOR, Kind.CONVERSION_FUNCTION, Kind.FUNCTION_TEMPLATE,
             Kind.LAMBDA_EXPR}
LITERALS = {Kind.INTEGER_LITERAL, Kind.FLOATING_LITERAL, Kind.CXX_BOOL_LITERAL_EXPR}
BODIES = {Kind.COMPOUND_STMT, Kind.IF_STMT, Kind.FOR_STMT, Kind.CXX_FOR_RANGE_STMT, Kind.WHILE_STMT}


def type_of(cursor):
    return cursor.type.get_canonical().kind


class File:
    def __init__(self, top, name):
        self.name = name
        self.bytes = (top / name).read_bytes()
        self.lines = self.bytes.decode().split('\n')
        self.arguments = [found.span() for found in re.finditer(rb'\btemplate \w+<[^<>]*>', self.bytes)]  # of member templates
        # offset -> texts put there: openings from the outermost on, closings from the innermost on.
        self.opened, self.closed, self.replaced = {}, {}, {}
        self.seen = set()
        self.mutants = []  # (offset, what); numbered when all files are known

    def text(self, begin, end):
        return self.bytes[begin:end].decode()

    def wrap(self, begin, end, opening, closing):
        self.opened.setdefault(begin, []).append((-end, opening))
        self.closed.setdefault(end, []).append((-begin, closing))

    def add(self, offset, *whats):
        """Places for mutants. Gives the mark that becomes the first one's number once those of all files are known."""
        first = len(self.mutants)
        self.mutants += [(offset, what) for what in whats]
        return f'\0{first}\0'

    def written(self, numbers):
        out, at = [], 0
        marks = sorted(set(self.opened) | set(self.closed) | set(self.replaced))
        for mark in marks:
            if mark < at:
                continue
            out.append(self.text(at, mark))
            at = mark
            out += [text for _, text in sorted(self.closed.get(mark, []), key=lambda one: one[0])]
            out += [text for _, text in sorted(self.opened.get(mark, []), key=lambda one: one[0])]
            if mark in self.replaced:
                length, text = self.replaced[mark]
                out.append(text)
                at = mark + length
        out.append(self.text(at, len(self.bytes)))
        pieces = ''.join(out).split('\0')
        pieces[1::2] = [str(numbers + int(index)) for index in pieces[1::2]]
        return '#include "tests/mutants/mutant_switch.hpp"\n#line 1\n' + ''.join(pieces)


class Writer:
    def __init__(self, file):
        self.file = file

    def operator(self, cursor, children):
        """The operator between two operands, and where it stands."""
        begin, end = children[0].extent.end.offset, children[1].extent.start.offset
        between = self.file.text(begin, end)
        word = between.strip()
        return (word, begin + between.index(word)) if word else ('', begin)

    def binary(self, cursor, children):
        begin, end = cursor.extent.start.offset, cursor.extent.end.offset
        word, at = self.operator(cursor, children)
        types = {type_of(child) for child in children}
        add = self.file.add
        if word in ('&&', '||'):
            both = word == '&&'
            first = add(at, f'{word} without its left', f'{word} without its right')
            second = f'\0{int(first.strip(chr(0))) + 1}\0'
            lead = 'hoist_mutants::on({}) || (' if both else '!hoist_mutants::on({}) && ('
            self.file.wrap(begin, end, '((' + lead.format(first), ')))' )
            self.file.replaced[at] = (2, f')) {word} (' + lead.format(second))
        elif word in COMPARED:
            name, opposite, edge = COMPARED[word]
            if TypeKind.DEPENDENT in types or TypeKind.RECORD in types:
                return
            if edge is None or types & REAL:
                number = add(at, f'{word} becomes {opposite}')
                name = name + ('_real' if edge else '')
            else:
                number = add(at, f'{word} becomes {opposite}', f'{word} becomes {edge}')
            self.file.wrap(begin, end, f'hoist_mutants::{name}({number}, (', '))')
            self.file.replaced[at] = (len(word), '), (')
        elif word in COUNTED and types <= WHOLE | REAL:
            name, changed = COUNTED[word]
            number = add(at, f'{word} becomes {changed}')
            self.file.wrap(begin, end, f'hoist_mutants::{name}({number}, (', '))')
            self.file.replaced[at] = (1, '), (')

    def constant(self, cursor, name):
        kind = type_of(cursor)
        begin, end = cursor.extent.start.offset, cursor.extent.end.offset
        if kind == TypeKind.BOOL:
            whats = [f'{name} is turned']
        elif kind in WHOLE:
            whats = [f'{name} is one more'] + ([f'{name} is one less'] if name[0] == 'k' else [])
        elif kind in REAL:
            whats = [f'{name} is doubled'] + ([f'{name} is halved'] if name[0] == 'k' else [])
        else:
            return
        call = 'number' if len(whats) == 1 else 'constant'
        self.file.wrap(begin, end, f'hoist_mutants::{call}({self.file.add(begin, *whats)}, ', ')')

    def turned(self, cursor, what):
        begin, end = cursor.extent.start.offset, cursor.extent.end.offset
        self.file.wrap(begin, end, f'(hoist_mutants::on({self.file.add(begin, what)}) != static_cast<bool>(', '))')

    def left_out(self, cursor):
        begin, end = cursor.extent.start.offset, cursor.extent.end.offset
        rest = self.file.text(end, min(end + 40, len(self.file.bytes)))
        semicolon = end + len(rest) - len(rest.lstrip())
        if self.file.text(semicolon, semicolon + 1) != ';':
            return
        what = ' '.join(self.file.text(begin, end).split())
        self.file.wrap(begin, semicolon + 1, f'{{ if (!hoist_mutants::on({self.file.add(begin, "left out: " + what[:60])})) ', ' }')


def inner(cursor):
    """The expression under clang's implicit wrappers, which have no kind of their own in libclang."""
    while cursor.kind in (Kind.UNEXPOSED_EXPR, Kind.PAREN_EXPR):
        children = list(cursor.get_children())
        if len(children) != 1:
            break
        cursor = children[0]
    return cursor


def visit(cursor, parent, files, inside):
    where = cursor.extent.start.file
    file = files.get(where.name) if where else None
    if where and file is None and parent is not None and parent.kind == Kind.TRANSLATION_UNIT:
        return
    kind = cursor.kind
    if kind in (Kind.STATIC_ASSERT,) or kind.is_attribute():
        return
    begin, end = cursor.extent.start.offset, cursor.extent.end.offset
    children = list(cursor.get_children())
    # What the compiler computes cannot be switched at run time.
    if file and kind in FUNCTIONS and 'consteval' in file.text(begin, cursor.location.offset):
        return
    if file and kind == Kind.DECL_STMT and file.text(begin, end).removeprefix('static ').startswith(('constexpr ', 'constinit ')):
        return
    if kind == Kind.VAR_DECL and file:
        if 'constexpr' in file.text(begin, cursor.location.offset) or 'constinit' in file.text(begin, cursor.location.offset):
            return
        children = [child for child in children if child.extent.start.offset > cursor.location.offset]
        if cursor.type.kind == TypeKind.CONSTANTARRAY:
            children = [child for child in children if file.text(child.extent.start.offset - 1, child.extent.start.offset) != '[']
    if kind == Kind.CASE_STMT:
        children = children[1:]
    if kind in (Kind.DECL_REF_EXPR, Kind.MEMBER_REF_EXPR, Kind.TYPE_REF, Kind.TEMPLATE_REF):
        literals = [child for child in children if child.kind in LITERALS or child.kind == Kind.DECL_REF_EXPR]
        if kind != Kind.MEMBER_REF_EXPR:
            children = [child for child in children if child not in literals]
    if kind == Kind.IF_STMT and file and file.text(begin, begin + 14).startswith('if constexpr'):
        children = children[1:]
    if file and kind in LITERALS and any(first < begin < last for first, last in file.arguments):
        return
    if inside and file and (begin, end, kind) not in file.seen and end > begin:
        writer = Writer(file)
        file.seen.add((begin, end, kind))
        if kind == Kind.BINARY_OPERATOR and len(children) == 2 and writer.operator(cursor, children)[0] != '=':
            writer.binary(cursor, children)
        elif kind == Kind.UNARY_OPERATOR and file.text(begin, begin + 1) == '!':
            writer.turned(cursor, '! is left out')
        elif kind in LITERALS:
            writer.constant(cursor, file.text(begin, end))
        elif kind == Kind.DECL_REF_EXPR and len(cursor.spelling) > 1 and cursor.spelling[0] == 'k' and cursor.spelling[1].isupper():
            writer.constant(cursor, cursor.spelling)
    if inside and file and kind in (Kind.IF_STMT, Kind.CONDITIONAL_OPERATOR) and children and children[0].kind.is_expression():
        first, core = children[0], inner(children[0])
        spot = (first.extent.start.offset, first.extent.end.offset, 'condition')
        if core.kind not in (Kind.BINARY_OPERATOR, Kind.UNARY_OPERATOR) and spot not in file.seen:
            file.seen.add(spot)
            Writer(file).turned(first, 'the condition is turned')
    if inside and file and kind in BODIES:
        for child in children:
            core = inner(child)
            text = file.text(child.extent.start.offset, child.extent.end.offset)
            statement = core.kind in (Kind.COMPOUND_ASSIGNMENT_OPERATOR, Kind.CALL_EXPR) or (
                core.kind == Kind.BINARY_OPERATOR and Writer(file).operator(core, list(core.get_children()))[0] == '=') or (
                core.kind == Kind.UNARY_OPERATOR and text[:2] in ('++', '--'))
            spot = (child.extent.start.offset, child.extent.end.offset, 'statement')
            first_of_head = kind in (Kind.IF_STMT, Kind.WHILE_STMT) and child == children[0]
            if statement and not first_of_head and kind not in (Kind.FOR_STMT, Kind.CXX_FOR_RANGE_STMT) and spot not in file.seen:
                file.seen.add(spot)
                Writer(file).left_out(child)
    for child in children:
        in_body = inside or (kind in FUNCTIONS and child.kind == Kind.COMPOUND_STMT)
        visit(child, cursor, files, in_body)


def main():
    top, out, listing, *folders = sys.argv[1:]
    top, out = pathlib.Path(top), pathlib.Path(out)
    names = sorted(str(path.relative_to(top)) for folder in folders for path in (top / folder).glob('*.?pp'))
    files = {str(top / name): File(top, name) for name in names}
    index = ci.Index.create()
    flags = ['-x', 'c++', '-std=c++20', f'-I{top}', '-isystem/usr/include/eigen3']
    headers = ''.join(f'#include "{name}"\n' for name in names if name.endswith('.hpp'))
    units = [(str(top / 'mutants_headers.cpp'), headers)] + [(str(top / name), None) for name in names if name.endswith('.cpp')]
    for path, text in units:
        unit = index.parse(path, flags, unsaved_files=[(path, text)] if text else None)
        wrong = [str(one) for one in unit.diagnostics if one.severity >= ci.Diagnostic.Error]
        if wrong:
            sys.exit('clang cannot read ' + path + '\n' + '\n'.join(wrong[:5]))
        visit(unit.cursor, None, files, False)
    number, rows = 0, []
    # The same change at another place of equal lines is told apart, or a reason given for one would hide the other.
    times = collections.Counter()
    for file in files.values():
        target = out / file.name
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_text(file.written(number))
        for offset, what in file.mutants:
            line = file.bytes.count(b'\n', 0, offset)
            source = file.lines[line].strip()
            times[file.name, what, source] += 1
            again = f' [{times[file.name, what, source]}]' if times[file.name, what, source] > 1 else ''
            rows.append(f'{number}\t{file.name}\t{line + 1}\t{what}{again}\t{source}')
            number += 1
    if number > MOST:
        sys.exit(f'{number} mutants: kMost of mutant_switch.hpp and MOST here have room for {MOST}')
    pathlib.Path(listing).write_text('\n'.join(rows) + '\n')


main()
