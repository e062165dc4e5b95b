"""What can be said about a program in Python without running it: from its syntax tree alone."""

import ast
import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from seamark.server.programs.diagnostics import Flaw
from seamark.server.programs.interfaces import ROLES, Role
from seamark.sim.metrics.syntax_trees import module_of

PARSED_MAX = 512 * 1024  # [B] over all files; what is longer is read in its box only
TEMPLATE = "The documentation has a template to start from."
_Method = ast.FunctionDef | ast.AsyncFunctionDef


def flaws_of(files: Mapping[str, bytes], main: str, role: str) -> list[Flaw]:
    """Return what is wrong with the texts, in the order of their lines; runs nothing of them.

    Parameters
    ----------
    files
        Path -> content, of Python files and of others, which are left alone.
    main
        The path of the file that defines the class of the role.
    """
    flaws, trees, room = list[Flaw](), dict[str, ast.Module](), PARSED_MAX
    for path in sorted(files, key=lambda path: path != main):
        if not path.endswith(".py") and path != main:
            continue
        room -= len(files[path])
        if room < 0:
            break
        flaw, tree = _read(path, files[path])
        if flaw is not None:
            flaws.append(flaw)
        if tree is not None:
            trees[path] = tree
    if main in trees:
        flaws += _interface(trees[main], main, ROLES[role])
    return flaws


def _read(path: str, content: bytes) -> tuple[Flaw | None, ast.Module | None]:
    """Return the tree of a text, or what keeps it from having one."""
    try:
        text = content.decode("utf-8-sig")
        return None, module_of(text, path)
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        return Flaw(sentence="The text is not UTF-8.", file=path, line=line), None
    except SyntaxError as error:
        where = (error.lineno, error.offset or None)
        return Flaw(sentence=f"{error.msg}.", file=path, line=where[0], column=where[1]), None
    except (ValueError, RecursionError, MemoryError):
        return Flaw(sentence="This is not a Python text that can be read.", file=path), None


@dataclass
class _Class:
    """What is known of the class: its methods, and whether it may have more."""

    node: ast.ClassDef
    methods: dict[str, _Method] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)  # also of assigned ones, whose arguments hide
    open_ended: bool = False  # a base, decorator or later assignment may bring methods


def _interface(tree: ast.Module, file: str, role: Role) -> Iterator[Flaw]:
    """Yield what the class lacks."""
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    if role.maker not in classes:
        if not _may_define(tree, role.maker):
            yield _missing(classes, file, role)
        return
    found = _Class(classes[role.maker])
    _collect(found, found.node, classes, depth=0)
    found.open_ended |= _used_elsewhere(tree, found.node)
    yield from _methods(found, file, role)


def _missing(classes: Mapping[str, ast.ClassDef], file: str, role: Role) -> Flaw:
    near = difflib.get_close_matches(role.maker, classes, n=1, cutoff=0.7)
    near = near or [name for name in classes if name.lower() == role.maker.lower()]
    if near:
        sentence = f"There is no class named {role.maker}, but {near[0]}: is that its name?"
        return Flaw(sentence=sentence, file=file, line=classes[near[0]].lineno)
    return Flaw(sentence=f"There is no class named {role.maker}. {TEMPLATE}", file=file)


def _may_define(tree: ast.Module, maker: str) -> bool:
    """Return whether the name may exist: a class, an assignment or an import, at any depth."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name == maker:
            return True
        if isinstance(node, ast.Name) and node.id == maker:
            return True
        if isinstance(node, ast.alias) and (node.asname or node.name) in {maker, "*"}:
            return True
    return False


def _collect(
    found: _Class, node: ast.ClassDef, classes: Mapping[str, ast.ClassDef], *, depth: int
) -> None:
    """Add the methods of a class and of its bases in the same file; the first one found counts."""
    for part in node.body:
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef):
            found.methods.setdefault(part.name, part)
            found.names.add(part.name)
        elif not isinstance(part, ast.Expr | ast.Pass | ast.ClassDef):
            found.names |= {n.id for n in ast.walk(part) if isinstance(n, ast.Name)}
            found.open_ended |= not isinstance(part, ast.Assign | ast.AnnAssign)
    found.open_ended |= bool(node.decorator_list or node.keywords)
    for base in node.bases:
        name = base.id if isinstance(base, ast.Name) else ""
        if name in classes and depth < len(classes):
            _collect(found, classes[name], classes, depth=depth + 1)
        elif name != "object":
            found.open_ended = True


def _used_elsewhere(tree: ast.Module, node: ast.ClassDef) -> bool:
    """Return whether the module does more with the class than defining it, such as setattr."""
    inside = {id(part) for part in ast.walk(node)}
    return any(
        isinstance(part, ast.Name) and part.id == node.name and id(part) not in inside
        for part in ast.walk(tree)
    )


def _methods(found: _Class, file: str, role: Role) -> Iterator[Flaw]:
    for name, arguments in (role.required | role.optional).items():
        call = f"{name}({', '.join(('self', *arguments))})"
        if name in found.methods:
            if reason := _refuses(found.methods[name], len(arguments)):
                line = found.methods[name].lineno
                yield Flaw(sentence=f"{name} {reason}; write {call}.", file=file, line=line)
        elif name in role.required and name not in found.names and not found.open_ended:
            sentence = f"{role.maker} has no method {call}."
            yield Flaw(sentence=sentence, file=file, line=found.node.lineno)


def _refuses(method: _Method, given: int) -> str | None:
    """Return why a call with `given` arguments after self would fail; None if it would not."""
    if isinstance(method, ast.AsyncFunctionDef):
        return "is async, but nothing awaits it"
    marks = {mark.id if isinstance(mark, ast.Name) else "?" for mark in method.decorator_list}
    if marks - {"staticmethod", "classmethod"}:
        return None  # a decorator may change the arguments
    given += "staticmethod" not in marks
    places = [*method.args.posonlyargs, *method.args.args]
    most = None if method.args.vararg else len(places)
    least = len(places) - len(method.args.defaults)
    named = [
        argument.arg
        for argument, default in zip(method.args.kwonlyargs, method.args.kw_defaults, strict=True)
        if default is None
    ]
    if named:
        return f"needs {named[0]} by name, which nobody gives"
    if given < least or (most is not None and given > most):
        took = f"{least}" if least == most else f"at least {least}" if given < least else f"{most}"
        return f"takes {took} argument{'' if took == '1' else 's'} and is called with {given}"
    return None
