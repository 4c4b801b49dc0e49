"""One kernel: its statements, variables where C wants them, and the checks that make C mean the same as Python."""

import ast
import inspect
import textwrap
from dataclasses import dataclass
from typing import Any

from polydraulic.export.translate.expressions import Expressions, Kernels
from polydraulic.export.translate.file_scope import FileScope
from polydraulic.export.translate.layout import WIDTH, wrapped
from polydraulic.export.translate.names import local_name
from polydraulic.export.translate.scopes import Use, comments_of, find_uses, is_elif
from polydraulic.export.translate.signatures import Function, Parameter
from polydraulic.export.translate.types import FLOAT, INT, NOTHING, Array, Struct, Type, comment, declare
from polydraulic.export.translate.values import PRODUCT, Value, shown

_INDENT = "    "


@dataclass
class _Slot:
    """Place of a declaration whose type is known only later."""

    name: str
    indent: str


class FunctionTranslator(Expressions):
    """Statements of one function; `translate` is the way in."""

    def __init__(self, scope: FileScope, kernels: Kernels, python: Any) -> None:
        super().__init__(scope, kernels, python)
        self.source, first = inspect.getsourcelines(python)
        self.first_line = first
        tree = ast.parse(textwrap.dedent("".join(self.source)))
        self.comments = comments_of("".join(self.source), first)
        ast.increment_lineno(tree, first - 1)
        definition = tree.body[0]
        assert isinstance(definition, ast.FunctionDef)
        self.definition = definition
        self.uses: dict[str, Use] = {}
        self.lines: list[str | _Slot] = []
        self.types: dict[str, Type] = {}
        self.result: Type | None = None
        self.loop_names: list[str] = []

    def translate(self, name: str, kinds: tuple[Type, ...], *, static: bool) -> Function:
        """Translate for arguments of the types `kinds`."""
        args = self.definition.args
        if args.vararg or args.kwarg or args.kwonlyargs or args.defaults:
            self.refuse(self.definition, "parameters must be plain, without defaults")
        names = [arg.arg for arg in args.args]
        if len(names) != len(kinds):
            self.refuse(self.definition, f"takes {len(names)} arguments, {len(kinds)} are given")
        body = self.definition.body
        doc = ast.get_docstring(self.definition)
        body = body[1:] if doc else body
        self.uses = find_uses(body)
        self.local_names = {*names, *self.uses}
        pointers = {}
        for parameter, kind in zip(names, kinds, strict=True):
            pointers[parameter] = self.scope.layouts.large(kind) and not self._assigned(parameter)
            self.variables[parameter] = Value(local_name(parameter), kind, pointer=pointers[parameter], place=True)
            self.types[parameter] = kind
        self.parameters, self.assigned = set(names), set(names)
        ended = self._block(body, _INDENT)
        read = {node.id for part in body for node in ast.walk(part) if isinstance(node, ast.Name)}
        if self.result is not None and self.result != NOTHING and not ended:
            self.refuse(self.definition, "does not return on every path")
        result = self.result or NOTHING
        parameters = [
            Parameter(local_name(n), kind, pointers[n], n in self.written) for n, kind in zip(names, kinds, strict=True)
        ]
        prototype = self._prototype(name, parameters, result, static)
        text = "\n".join(
            [
                *([comment(doc.splitlines()[0])] if doc else []),
                prototype,
                "{",
                *(f"{_INDENT}(void){local_name(name)};" for name in names if name not in read),
                *(line if isinstance(line, str) else self._declaration(line) for line in self.lines),
                "}",
                "",
            ]
        )
        return Function(name, self.python, parameters, result, self.types, text, prototype)

    def _prototype(self, name: str, parameters: list[Parameter], result: Type, static: bool) -> str:
        struct_name = self.scope.struct_name
        texts = []
        for p in parameters:
            if isinstance(p.type, Array) and len(p.type.shape) > 1 and p.written:
                self.refuse(self.definition, f"{p.name}: only arrays of one dimension may be written")
            constant = (p.pointer or isinstance(p.type, Array)) and not p.written
            texts.append(declare(p.type, f"*{p.name}" if p.pointer else p.name, struct_name, constant=constant))
        kind = declare(result, name, struct_name, constant=False)
        # numba inlines all kernels; without the word gcc leaves some calls, and a step takes a tenth longer
        return wrapped(f"{'static inline ' if static else ''}{kind}({', '.join(texts) or 'void'})", "")

    def _declaration(self, slot: _Slot) -> str:
        kind = self.types[slot.name]
        text = declare(kind, local_name(slot.name), self.scope.struct_name, constant=isinstance(kind, Array))
        return f"{slot.indent}{text};"

    # where variables live

    def _assigned(self, name: str) -> int:
        return self.uses[name].times_assigned if name in self.uses else 0

    # statements

    def _block(self, body: list[ast.stmt], indent: str) -> bool:
        """Translate statements; returns whether the end is not reached."""
        for number, statement in enumerate(body):
            self._comments_before(statement, indent, first=number == 0)
            own = self._targets(statement)
            for name, use in self.uses.items():
                hoisted = use.home() == (id(body), number) and name not in (*own, *self.variables, *self.loop_names)
                if hoisted and not self._binds_loop(statement, name):
                    self.lines.append(_Slot(name, indent))
            if self._statement(statement, body, number, indent):
                return True
        return False

    @staticmethod
    def _targets(statement: ast.stmt) -> list[str]:
        """Names that a statement assigns, and may declare."""
        targets: list[ast.expr] = []
        if isinstance(statement, ast.Assign):
            targets = statement.targets
        elif isinstance(statement, ast.AnnAssign):
            targets = [statement.target]
        parts = [part for target in targets for part in (target.elts if isinstance(target, ast.Tuple) else [target])]
        return [part.id for part in parts if isinstance(part, ast.Name)]

    @staticmethod
    def _binds_loop(statement: ast.stmt, name: str) -> bool:
        return any(
            isinstance(node, ast.For) and isinstance(node.target, ast.Name) and node.target.id == name
            for node in ast.walk(statement)
        )

    def _statement(self, s: ast.stmt, body: list[ast.stmt], number: int, indent: str) -> bool:
        here = (id(body), number)
        match s:
            case ast.Pass():
                return False
            case ast.Break() | ast.Continue():
                self._line(s, indent, "break;" if isinstance(s, ast.Break) else "continue;")
                return True
            case ast.Return():
                return self._return(s, indent)
            case ast.Expr(value=ast.Call()):
                self._line(s, indent, f"{self.value(s.value, whole=True).text};")
            case (
                ast.AnnAssign(target=ast.Name(), value=ast.expr()) | ast.Assign(targets=[ast.Name() | ast.Subscript()])
            ):
                target = s.target if isinstance(s, ast.AnnAssign) else s.targets[0]
                assert s.value is not None
                self._assign(s, target, s.value, here, indent)
            case ast.Assign(targets=[ast.Tuple() as targets], value=ast.Tuple() as values):
                self._assign_several(s, targets.elts, values.elts, here, indent)
            case ast.AugAssign():
                self._augment(s, indent)
            case ast.If():
                return self._if(s, indent)
            case ast.For():
                self._for(s, indent)
            case ast.While():
                self.refuse(s, "a while loop has no bound; write 'for _ in range(bound)' with a break")
            case ast.Assign(targets=[ast.Tuple()]):
                self.refuse(s, "name the result and use its fields instead of unpacking it")
            case _:
                self.refuse(s, f"no C is known for {ast.unparse(s).splitlines()[0]!r}")
        return False

    def _return(self, s: ast.Return, indent: str) -> bool:
        value = self.value(s.value, whole=True) if s.value is not None else Value("", NOTHING)
        self.result = value.type if self.result is None else self.result
        if self.result == NOTHING:
            self._line(s, indent, "return;")
            return True
        if isinstance(value.type, Array):
            self.refuse(s, "returns an array; let the caller hand one over to be filled")
        self._line(s, indent, f"return {self.converted(s, value, self.result, 'the result').text};")
        return True

    def _assign(self, s: ast.stmt, target: ast.expr, source: ast.expr, here: tuple[int, int], indent: str) -> None:
        if isinstance(target, ast.Subscript):
            place = self._stored(target)
            given = self.value(source, whole=self._quiet(target.slice))
            value = self.converted(s, given, place.type, ast.unparse(target))
            self._line(s, indent, f"{place.text} = {value.text};")
            return
        assert isinstance(target, ast.Name)
        name = target.id
        if self._dispatches(name, source):
            return
        value = self.value(source, whole=True)
        if value.type == NOTHING:
            self.refuse(s, f"{ast.unparse(source)} gives nothing")
        first = name not in self.types
        kind = self.types.setdefault(name, value.type)
        if isinstance(kind, Array) and isinstance(value.type, Array) and name in self.written:
            self.refuse(s, f"{name} is written; use the array itself")
        if not first and value.type != kind:
            self.refuse(
                s, f"{name} is {shown(kind)} and gets {shown(value.type)}; a name has one type (0.0 is a float)"
            )
        only = self.uses[name].times_assigned == 1
        if first and self.uses[name].home() == here:
            if only and value.place and self._stays(source) and self.scope.layouts.large(kind):
                text = declare(kind, f"*{local_name(name)}", self.scope.struct_name)
                self.variables[name] = Value(local_name(name), kind, pointer=True, place=True)
                self._line(s, indent, f"{text} = {value.text if value.pointer else '&' + value.text};")
                self.assigned.add(name)
                return
            text = declare(kind, local_name(name), self.scope.struct_name, constant=only or isinstance(kind, Array))
        else:
            text = local_name(name)
        self.variables[name] = Value(local_name(name), kind, place=True)
        initial = self.converted(s, value, kind, name).text
        if isinstance(kind, Struct) and text != local_name(name):
            initial = initial.removeprefix(f"({self.scope.struct_name(kind.cls)})")  # {...} alone starts a variable
        self._line(s, indent, f"{text} = {initial};")
        self.assigned.add(name)

    def _stays(self, source: ast.expr) -> bool:
        """Whether `source` is part of a parameter or variable that never changes, so that a pointer does for a copy."""
        root = source
        while isinstance(root, ast.Attribute):
            root = root.value
        if not isinstance(root, ast.Name):
            return False
        return self._assigned(root.id) == (0 if root.id in self.parameters else 1)

    def _dispatches(self, name: str, source: ast.expr) -> bool:
        """`step = TABLE[type(model)]`: the name stands for the function from here on."""
        match source:
            case ast.Subscript(value=table, slice=ast.Call(func=ast.Name(id="type"), args=[ast.Name(id=chosen)])):
                entries, kind = self.known(table), self.value(ast.Name(chosen, ast.Load(), lineno=source.lineno)).type
                if isinstance(entries, dict) and isinstance(kind, Struct) and kind.cls in entries:
                    self.steps[name] = entries[kind.cls]
                    return True
                self.refuse(source, f"{ast.unparse(table)} has no entry for {shown(kind)}")
        return False

    def _assign_several(
        self, s: ast.stmt, targets: list[ast.expr], values: list[ast.expr], here: tuple[int, int], indent: str
    ) -> None:
        if len(targets) != len(values):
            self.refuse(s, f"{len(targets)} targets for {len(values)} values")
        changed: set[str] = set()
        for target, value in zip(targets, values, strict=True):
            read = {node.id for node in ast.walk(value) if isinstance(node, ast.Name)}
            if read & changed:
                self.refuse(
                    s, f"{', '.join(sorted(read & changed))} is read after it has changed; assign one after the other"
                )
            self._assign(s, target, value, here, indent)
            root = target.value if isinstance(target, ast.Subscript) else target
            changed |= {root.id} if isinstance(root, ast.Name) else set()

    def _stored(self, target: ast.Subscript) -> Value:
        """Element of an array that is a parameter, and noted as written."""
        if not (isinstance(target.value, ast.Name) and target.value.id in self.parameters):
            self.refuse(
                target, f"{ast.unparse(target)}: only arrays that are parameters of this function may be written"
            )
        self.written.add(target.value.id)
        return self.value(ast.Subscript(target.value, target.slice, ast.Load(), lineno=target.lineno))

    def _augment(self, s: ast.AugAssign, indent: str) -> None:
        target = self._stored(s.target) if isinstance(s.target, ast.Subscript) else None
        if isinstance(s.target, ast.Name):
            target = self.value(ast.Name(s.target.id, ast.Load(), lineno=s.lineno))
        if target is None:
            self.refuse(s, "only variables and elements of arrays change")
        value = self.number(s.value)
        sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}.get(type(s.op))
        if sign is None or (target.type != FLOAT and (sign == "/" or value.type == FLOAT)):
            self.refuse(s, f"{ast.unparse(s)}: write it out, or make {ast.unparse(s.target)} a float")
        self._line(s, indent, f"{target.text} {sign}= {self.converted(s, value, target.type, target.text).text};")

    def _if(self, s: ast.If, indent: str, lead: str = "") -> bool:
        self._line(s, indent, f"{lead}if ({self.condition(s.test).text}) {{")
        before = set(self.assigned)
        ended = self._block(s.body, indent + _INDENT)
        after, self.assigned, other = self.assigned, set(before), False
        if is_elif(s.orelse):
            other = self._if(s.orelse[0], indent, "} else ")  # type: ignore[arg-type]
        else:
            if s.orelse:
                self.lines.append(f"{indent}}} else {{")
                other = self._block(s.orelse, indent + _INDENT)
            self.lines.append(f"{indent}}}")
        self.assigned = self.assigned if ended else after if other else after & self.assigned
        return ended and other

    def _for(self, s: ast.For, indent: str) -> None:
        match s:
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"), args=bounds), orelse=[]):
                pass
            case _:
                self.refuse(s, "only 'for name in range(...)' without else has a counterpart")
        if len(bounds) not in (1, 2):
            self.refuse(s, "range has a start and an end, and steps of 1")
        changed = {
            node.id
            for part in s.body
            for node in ast.walk(part)
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
        }
        read = {node.id for bound in bounds for node in ast.walk(bound) if isinstance(node, ast.Name)}
        if name != "_" and (name in changed or name in self.assigned):
            self.refuse(s, f"{name} counts this loop and may not be used for something else, nor change inside")
        low, high = (self.value(bound) for bound in ([ast.Constant(0)] if len(bounds) == 1 else []) + bounds)
        if (low.type, high.type) != (INT, INT):
            self.refuse(s, f"range of {shown(low.type)} to {shown(high.type)}; must be whole numbers")
        counter = f"turn{len(self.loop_names)}" if name == "_" else local_name(name)
        self._line(
            s, indent, f"for (int64_t {counter} = {low.text}; {counter} < {high.inside(PRODUCT)}; {counter}++) {{"
        )
        before = set(self.assigned)
        outer = self.variables.get(name)
        self.variables[name], self.types[name] = Value(counter, INT), INT
        self.assigned.add(name)
        self.loop_names.append(name)
        self._block(s.body, indent + _INDENT)
        if read & (changed | self.written):
            self.refuse(s, f"the bounds read {', '.join(sorted(read))}, which may not change inside the loop")
        self.loop_names.pop()
        self.lines.append(f"{indent}}}")
        self.assigned = before
        if outer is not None:
            self.variables[name] = outer

    # text

    def _line(self, s: ast.stmt, indent: str, text: str) -> None:
        line = wrapped(text, indent)
        if s.end_lineno == s.lineno and s.lineno in self.comments:
            note = comment(self.comments.pop(s.lineno))
            if len(line) + len(note) < WIDTH and "\n" not in line:
                line = f"{line} {note}"
            else:
                self.lines.append(indent + note)
        self.lines.append(line)

    def _comments_before(self, s: ast.stmt, indent: str, *, first: bool) -> None:
        """Comments and the empty line above a statement."""
        inside = not hasattr(s, "body") and s.end_lineno != s.lineno  # between the lines of one statement
        notes = [line for line in sorted(self.comments) if line < s.lineno or (inside and line <= (s.end_lineno or 0))]
        above = self.source[min([*notes, s.lineno]) - self.first_line - 1]
        if not above.strip() and not first:
            self.lines.append("")
        self.lines += [comment(self.comments.pop(line), indent) for line in notes]
