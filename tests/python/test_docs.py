"""The code blocks of docs/python.md run from top to bottom; the page, the stub and the module have the same signatures."""

import ast
import inspect
import re
import types

import gelenk


def test_the_pages_code_runs(root, tmp_path, monkeypatch):
    text = (root / "docs/python.md").read_text()
    blocks = list(re.finditer(r"^```python\n(.*?)^```", text, re.S | re.M))
    assert blocks
    monkeypatch.chdir(root)
    space = {"__name__": "docs", "OUT": tmp_path}
    for block in blocks:
        line = text[: block.start()].count("\n") + 1
        exec(compile("\n" * line + block.group(1), "docs/python.md", "exec"), space)


# ---- signatures: (name, kind of parameter, default) of each parameter, without self


def signature(arguments):
    """Of an ast.arguments."""
    plain = arguments.posonlyargs + arguments.args
    defaults = [None] * (len(plain) - len(arguments.defaults)) + arguments.defaults
    rows = [(a.arg, "plain", d) for a, d in zip(plain, defaults)]
    rows += [("", "*", None)] if arguments.vararg else []
    rows += [(a.arg, "keyword", d) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults)]
    rows += [("", "**", None)] if arguments.kwarg else []
    return [(name, kind, None if d is None else repr(ast.literal_eval(d))) for name, kind, d in rows if name != "self"]


def parsed(text):
    """Of "name(...)", as pybind11 writes it or as the page does."""
    return signature(ast.parse(f"def {text}: ...").body[0].args)


def written_in_python(function):
    kinds = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.KEYWORD_ONLY: "keyword", inspect.Parameter.VAR_KEYWORD: "**"}
    return [("" if "*" in kinds.get(p.kind, "") else p.name, kinds.get(p.kind, "plain"), None if p.default is p.empty else repr(p.default))
            for p in inspect.signature(function).parameters.values() if p.name != "self"]


def of_module(thing):
    """Of a function, a method or a class of the module; None where it has none, as a property."""
    if isinstance(thing, type):
        return of_module(thing.__init__)
    if isinstance(thing, (types.FunctionType, staticmethod)):
        return written_in_python(thing)
    first = (thing.__doc__ or "").split("\n")[0]
    return parsed(first) if re.match(r"\w+\(.*\) -> ", first) else None


def public(module):
    """(name, thing) of all that a user may call or read: f, C, C.method, C.property."""
    for name in dir(module):
        thing = getattr(module, name)
        if name.startswith("_") or isinstance(thing, types.ModuleType):
            continue
        yield name, thing
        if isinstance(thing, type) and not issubclass(thing, Exception):
            for member in vars(thing):
                if not member.startswith("_"):
                    yield f"{name}.{member}", getattr(thing, member)


def stub_of(root):
    """name -> signature, None for what is no function."""
    found = {}
    for node in ast.parse((root / "apps/python/gelenk/__init__.pyi").read_text()).body:
        if isinstance(node, ast.FunctionDef):
            found[node.name] = signature(node.args)
        if isinstance(node, ast.ClassDef):
            found[node.name] = None
            for member in node.body:
                if isinstance(member, ast.AnnAssign):
                    found[f"{node.name}.{member.target.id}"] = None
                elif isinstance(member, ast.FunctionDef) and member.name == "__init__":
                    found[node.name] = signature(member.args)
                elif isinstance(member, ast.FunctionDef) and not member.name.startswith("_"):
                    property_ = any("property" in ast.unparse(d) or "setter" in ast.unparse(d) for d in member.decorator_list)
                    found[f"{node.name}.{member.name}"] = None if property_ else signature(member.args)
    return found


made_by_the_module = {"Picture", "Page", "Blend", "Skin", "Result", "BatchResult", "Problem", "Model", "Contract", "Comparison", "View"}


def test_the_stub_has_the_modules_signatures(root):
    stub = stub_of(root)
    for name, thing in public(gelenk):
        assert name in stub, name
        if not (name in made_by_the_module or isinstance(thing, property) or (isinstance(thing, type) and issubclass(thing, Exception))):
            assert stub[name] == of_module(thing), name
    set_by_init = {"View": "model on_change", "Page": "address", "Contract": "solver problems solved unsupported faults", "Comparison": "columns checksums",
                   "ParseError": "file line expected found"}
    members = {f"{kind}.{member}" for kind, words in set_by_init.items() for member in words.split()}
    assert set(stub) - {name for name, _ in public(gelenk)} == members


def test_the_page_has_every_signature(root):
    """Each function, class and method stands in the page as `name(...)`, a property as `.name`."""
    text = (root / "docs/python.md").read_text()
    calls = {}
    for name, arguments in re.findall(r"`@?(?:\w*\.)?(\w+)\(([^`\n]*)\)`", text):
        try:
            calls.setdefault(name, []).append(parsed(f"{name}({arguments})"))
        except (SyntaxError, ValueError):  # a call with values, no signature
            pass
    for name, wanted in stub_of(root).items():
        short = name.split(".")[-1]
        if wanted is None:
            assert re.search(rf"`[^`\n]*\b{short}\b[^`\n]*`", text), name
        else:
            assert wanted in calls.get(short, []), (name, wanted, calls.get(short))


def test_docstrings_speak_python():
    """Every public thing says what it is in a sentence, and none names a type of C++."""
    for name, thing in public(gelenk):
        first, _, sentence = (thing.__doc__ or "").strip().partition("\n")
        assert "::" not in first, (name, first)
        assert sentence.strip() or not re.match(r"\w+\(.*\) -> |$", first), (name, first)
