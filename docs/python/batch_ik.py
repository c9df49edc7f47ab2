# %% [markdown]
# # Many poses at once

# %%
import time

import numpy as np
import gelenk

panda = gelenk.model("panda")
tool = panda.index("tool")
poses = panda.fk(panda.random(1, 10_000))[:, tool]
begin = time.perf_counter()
answers = gelenk.solve(panda, poses)
seconds = time.perf_counter() - begin
print(f"{answers.solved.sum()} of {len(answers)} solved, {len(answers) / seconds:.0f} a second")

# %% [markdown]
# The judge's word is checked by forward kinematics:

# %%
errors = np.linalg.norm(panda.fk(answers.q)[:, tool, :3, 3] - poses[:, :3, 3], axis=1)
print("largest error:", errors[answers.solved].max(), "m")
assert errors[answers.solved].max() <= 1e-6
