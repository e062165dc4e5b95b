"""Static checks of a Python program: its syntax tree is inspected, nothing is run."""

import ast
import difflib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from seamark.programs.diagnostics import Diagnostic
from seamark.programs.interfaces import INTERFACES, Interface

PARSED_MAX = 512 * 1024  # [B] over all files; anything beyond is first parsed in the sandbox
TEMPLATE = "The documentation has a template to start from."
_Method = ast.FunctionDef | ast.AsyncFunctionDef


def lint(files: Mapping[str, bytes], main: str, role: str) -> list[Diagnostic]:
    """Return the problems found in the source, in the order of the files and lines.

    Parameters
    ----------
    files
        Path -> content. Files other than Python are skipped.
    main
        Path of the file that defines the class.
    role
        A key of `INTERFACES`.
    """
    diagnostics, trees, remaining = list[Diagnostic](), dict[str, ast.Module](), PARSED_MAX
    for path in sorted(files, key=lambda path: path != main):
        if not path.endswith(".py") and path != main:
            continue
        remaining -= len(files[path])
        if remaining < 0:
            break
        tree = _parse(path, files[path])
        if isinstance(tree, Diagnostic):
            diagnostics.append(tree)
        else:
            trees[path] = tree
    if main in trees:
        diagnostics += _check_interface(trees[main], main, INTERFACES[role])
    return diagnostics


def _parse(path: str, content: bytes) -> ast.Module | Diagnostic:
    try:
        return ast.parse(content.decode("utf-8-sig"), filename=path)
    except UnicodeDecodeError as error:
        first_bad = content[: error.start].count(b"\n") + 1
        return Diagnostic(sentence="The source is not UTF-8.", file=path, line=first_bad)
    except SyntaxError as error:
        line, column = error.lineno, error.offset or None
        return Diagnostic(sentence=f"{error.msg}.", file=path, line=line, column=column)
    except (ValueError, RecursionError, MemoryError):
        return Diagnostic(sentence="The file cannot be parsed as Python.", file=path)


@dataclass
class _Class:
    """What the source shows of the class."""

    node: ast.ClassDef
    methods: dict[str, _Method] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)  # including assigned ones: signature unknown
    open_ended: bool = False  # a base class, decorator or later assignment may add methods


def _check_interface(tree: ast.Module, file: str, interface: Interface) -> Iterator[Diagnostic]:
    classes = {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    if interface.class_name not in classes:
        if not _may_define(tree, interface.class_name):
            yield _class_missing(classes, file, interface.class_name)
        return
    outline = _Class(classes[interface.class_name])
    _collect(outline, classes)
    outline.open_ended |= _used_elsewhere(tree, outline.node)
    yield from _check_methods(outline, file, interface)


def _class_missing(classes: Mapping[str, ast.ClassDef], file: str, name: str) -> Diagnostic:
    similar = difflib.get_close_matches(name, classes, n=1, cutoff=0.7)
    similar = similar or [other for other in classes if other.lower() == name.lower()]
    if similar:
        sentence = f"There is no class {name}. Did you mean to call {similar[0]} {name}?"
        return Diagnostic(sentence=sentence, file=file, line=classes[similar[0]].lineno)
    return Diagnostic(sentence=f"There is no class {name}. {TEMPLATE}", file=file)


def _may_define(tree: ast.Module, name: str) -> bool:
    """Return whether a class, an assignment or an import at any depth may define the name."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef) and node.name == name:
            return True
        if isinstance(node, ast.Name) and node.id == name:
            return True
        if isinstance(node, ast.alias) and (node.asname or node.name) in {name, "*"}:
            return True
    return False


def _collect(outline: _Class, classes: Mapping[str, ast.ClassDef]) -> None:
    """Add the methods of the class and of its bases in the same file, in resolution order.

    Every class is visited once, however many paths lead to it: of methods with one name the first
    counts, so that a second visit would add nothing.
    """
    waiting, visited = [outline.node], set[str]()
    while waiting:
        node = waiting.pop()
        if node.name in visited:
            continue
        visited.add(node.name)
        _add_body(outline, node)
        names = [base.id if isinstance(base, ast.Name) else "" for base in node.bases]
        outline.open_ended |= any(name not in classes and name != "object" for name in names)
        waiting += [classes[name] for name in reversed(names) if name in classes]


def _add_body(outline: _Class, node: ast.ClassDef) -> None:
    """Add what the body of one class defines."""
    for part in node.body:
        if isinstance(part, ast.FunctionDef | ast.AsyncFunctionDef):
            outline.methods.setdefault(part.name, part)
            outline.names.add(part.name)
        elif not isinstance(part, ast.Expr | ast.Pass | ast.ClassDef):
            outline.names |= {n.id for n in ast.walk(part) if isinstance(n, ast.Name)}
            outline.open_ended |= not isinstance(part, ast.Assign | ast.AnnAssign)
    outline.open_ended |= bool(node.decorator_list or node.keywords)


def _used_elsewhere(tree: ast.Module, node: ast.ClassDef) -> bool:
    """Return whether the module uses the class outside its definition, such as in setattr."""
    inside = {id(part) for part in ast.walk(node)}
    return any(
        isinstance(part, ast.Name) and part.id == node.name and id(part) not in inside
        for part in ast.walk(tree)
    )


def _check_methods(outline: _Class, file: str, interface: Interface) -> Iterator[Diagnostic]:
    for name, arguments in (interface.required | interface.optional).items():
        signature = f"{name}({', '.join(('self', *arguments))})"
        if name in outline.methods:
            if reason := _not_callable(outline.methods[name], len(arguments)):
                line = outline.methods[name].lineno
                sentence = f"{name} {reason}; write {signature}."
                yield Diagnostic(sentence=sentence, file=file, line=line)
        elif name in interface.required and name not in outline.names and not outline.open_ended:
            sentence = f"{interface.class_name} has no method {signature}."
            yield Diagnostic(sentence=sentence, file=file, line=outline.node.lineno)


def _not_callable(method: _Method, given: int) -> str | None:
    """Return why a call with `given` arguments after self would fail; None if it would not."""
    if isinstance(method, ast.AsyncFunctionDef):
        return "is async, but is never awaited"
    decorators = {node.id if isinstance(node, ast.Name) else "?" for node in method.decorator_list}
    if decorators - {"staticmethod", "classmethod"}:
        return None  # a decorator may change the signature
    given += "staticmethod" not in decorators
    positional = [*method.args.posonlyargs, *method.args.args]
    most = None if method.args.vararg else len(positional)
    least = len(positional) - len(method.args.defaults)
    keyword_only = [
        argument.arg
        for argument, default in zip(method.args.kwonlyargs, method.args.kw_defaults, strict=True)
        if default is None
    ]
    if keyword_only:
        return f"has the required keyword-only argument {keyword_only[0]}, which is never passed"
    if given < least or (most is not None and given > most):
        count = f"{least}" if least == most else f"at least {least}" if given < least else f"{most}"
        return f"takes {count} argument{'' if count == '1' else 's'} but is called with {given}"
    return None
