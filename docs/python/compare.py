# %% [markdown]
# # Comparing solvers in ten lines

# %%
import gelenk

race = gelenk.compare(gelenk.model("panda"), ["default", "dls", "dls[lambda=0.2]", "lm-sugihara"], sets=["D1", "D2"],
                      problems=50, seed=1)
print(race)
best = max(race.summary(), key=lambda row: (row.solved, -row.microseconds))
print("most solved, then fastest:", best.solver)
assert best.solver == "default" and best.solved == 1
table = race.table  # a pandas DataFrame where pandas is installed, else a numpy record array
assert len(table) == len(race)
