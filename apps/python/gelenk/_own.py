"""One's own methods in the catalogue, and the laboratory's comparison."""

import inspect
import tempfile

import numpy as np

from . import _gelenk


def _python_name(parameter):
    """lambda -> lambda_, largest-step -> largest_step: how a function writes a parameter."""
    import keyword

    name = parameter.replace("-", "_").rstrip("_")
    return name + "_" if keyword.iskeyword(name) else name


def _join(kind, name, parameters, title, largest_step, stochastic):
    parameters = dict(parameters or {})

    def join(function):
        taken = inspect.signature(function).parameters
        every = any(p.kind is p.VAR_KEYWORD for p in taken.values())
        keywords = {}
        for parameter in parameters:
            word = _python_name(parameter)
            if every or word in taken:
                keywords[parameter.rstrip("_").replace("_", "-")] = word
        _gelenk._add_solver(kind, name, function, parameters, keywords, title or name, largest_step, stochastic)
        return function

    return join


def step_rule(name, *, parameters=None, title="", largest_step=0.5):
    """Decorator: a function (J, r, q) -> dq joins the catalogue of this process as a solver.

    J: (m, nv) Jacobian, with the dimensions taken out that limits lock; r: (m,) residual, target minus current, metres and
    radians; q: (nq,). dq: (nv,). Limits, restarts, stopping and counting are those of the classic methods; steps longer than
    largest_step (radians, metres) in a coordinate are shortened as a whole. parameters: {"lambda": 0.1} or
    {"lambda": (default, lower, upper)}; the function takes those that it names as keywords (lambda_).
    """
    return _join("step_rule", name, parameters, title, largest_step, False)


def solver(name, *, parameters=None, title="", stochastic=False):
    """Decorator: a function (problem) -> q joins the catalogue of this process as a solver.

    problem: a gelenk.Problem. The answer must be within limits (problem.integrate and problem.project see to that); the
    judge decides whether it is solved.
    """
    return _join("solver", name, parameters, title, 0.5, stochastic)


class Comparison:
    """What compare() found: columns by name (len rows each), checksums of the problem sets, summary() and table."""

    def __init__(self, columns, checksums):
        self.columns = {k: np.asarray(v) for k, v in columns.items()}
        self.checksums = checksums

    def __len__(self):
        return len(self.columns["solver"])

    def __getitem__(self, name):
        return self.columns[name]

    @property
    def table(self):
        """A pandas DataFrame where pandas is installed, else a numpy record array."""
        try:
            import pandas
        except ImportError:
            return np.rec.fromarrays(list(self.columns.values()), names=list(self.columns))
        return pandas.DataFrame(self.columns)

    def summary(self):
        """One row a set and solver: a numpy record array of set, solver, problems, solved (share), iterations (median),
        microseconds (median)."""
        rows = []
        keys = list(dict.fromkeys(zip(self["set"].tolist(), self["solver"].tolist())))
        for set_, name in keys:
            mine = (self["set"] == set_) & (self["solver"] == name)
            rows.append((set_, name, mine.sum(), self["solved"][mine].mean(), np.median(self["iterations"][mine]),
                         1e6 * np.median(self["seconds"][mine])))
        return np.rec.fromrecords(rows, names="set,solver,problems,solved,iterations,microseconds")

    def __repr__(self):
        lines = [f"{'set':<18} {'solver':<28} {'problems':>8} {'solved':>8} {'iterations':>10} {'us':>10}"]
        for row in self.summary():
            lines.append(f"{row.set:<18} {row.solver:<28} {row.problems:>8} {100 * row.solved:>7.1f}% "
                         f"{row.iterations:>10.0f} {row.microseconds:>10.1f}")
        return "\n".join(lines)


def compare(model, solvers=None, *, sets=("D1",), problems=1000, seed=1, tolerance=1e-6, max_iterations=200,
            restarts=None, effectors=(), goal="", out=None, progress=None):
    """Solvers on the laboratory's frozen problem sets, as `gelenk compare`: a Comparison.

    solvers: texts such as "dls[lambda=0.1]", own ones too; default: all. restarts: None asks every set twice, with none and
    with 50. goal: "pose" or "position". out: a folder for tables and report, where an interrupted run goes on.
    progress: a function (done, total, what).
    """
    if isinstance(sets, str):
        sets = (sets,)
    if isinstance(solvers, str):
        solvers = (solvers,)
    if solvers is None:
        solvers = [entry["name"] for entry in _gelenk.solvers()]

    def run(folder):
        return _gelenk._compare(model, list(solvers), list(sets), problems, seed, tolerance, max_iterations, restarts,
                                list(effectors), goal, str(folder), out is not None, progress)

    if out is not None:
        found = run(out)
    else:
        with tempfile.TemporaryDirectory() as folder:
            found = run(folder + "/results")
    return Comparison(found["columns"], found["checksums"])
