# %% [markdown]
# # A solver of one's own in twenty lines
# Selectively damped least squares (Buss and Kim 2005) as a step rule: J (m x nv) and the residual r (m) go in, dq (nv) comes
# out. Limits, restarts, stopping and counting are those of all solvers.

# %%
import numpy as np
import gelenk


@gelenk.step_rule("my-sdls", parameters={"gamma-max": 0.7854, "largest-error": (0.3, 0.01, 10)}, largest_step=0.7854)
def my_sdls(J, r, q, gamma_max, largest_error):
    blocks = [slice(i, i + 3) for i in range(0, len(r), 3)]  # a place or a rotation each
    r = r.copy()
    for b in blocks:
        r[b] *= min(1.0, largest_error / max(np.linalg.norm(r[b]), 1e-300))
    U, sigma, Vt = np.linalg.svd(J, full_matrices=False)
    dq = np.zeros(J.shape[1])
    for i in range(len(sigma)):
        if sigma[i] <= 1e-7 * sigma[0]:
            continue
        N = sum(np.linalg.norm(U[b, i]) for b in blocks)
        M = sum(np.abs(Vt[i]) @ np.linalg.norm(J[b], axis=0) for b in blocks) / sigma[i]
        gamma = gamma_max * min(1.0, N / M)
        part = (U[:, i] @ r) / sigma[i] * Vt[i]
        dq += part * min(1.0, gamma / max(np.abs(part).max(), 1e-300))
    return dq


# %% [markdown]
# The same answers as the solver of the catalogue, to rounding:

# %%
defaults = {p["name"]: p["value"] for s in gelenk.solvers() if s["name"] == "sdls" for p in s["parameters"]}
mine = dict(gamma_max=defaults["gamma-max"], largest_error=defaults["largest-error"])
arm = gelenk.model("planar")
rng = np.random.default_rng(1)
for _ in range(20):
    start, target = arm.random(rng), arm.fk(arm.random(rng))[-1][:3, 3]
    a = gelenk.solve(arm, target, start=start, solver="sdls", restarts=0)
    b = gelenk.solve(arm, target, start=start, solver="my-sdls", restarts=0, **mine)
    assert a.status == b.status and a.iterations == b.iterations
    assert np.allclose(a.q, b.q, atol=1e-9)

# %% [markdown]
# Held to the rules of every solver, and raced against others:

# %%
print(gelenk.check("my-sdls", problems=10))
race = gelenk.compare(gelenk.model("ur5"), ["dls", "sdls", "my-sdls"], problems=50, restarts=0)
print(race)
