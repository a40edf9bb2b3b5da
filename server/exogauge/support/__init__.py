"""Supporting torque of a worn device: without minus with it on the same motion (A), model minus measurement (B).

- `settings`, `motions`, `same_motion`, `labels`, `notes`: which log is compared with which, and what looks like a slip
- `difference`, `paired`, `balance`, `at_rest`: the estimates, and what they are worth where a joint stands still
- `coloured`, `drift`, `zeros`: errors that last, what motors gave and feet read in every log of a session
- `inputs`, `evidence`, `effort`, `phases`, `peak`, `repeatability`, `best`, `summary`: numbers of a motion, their
  doubt, the best
- `rows_of_approach`, `band_rows`, `band_model`, `band_nuisances`, `band_weights`, `band_fit`: bands fitted to
  supporting torques
- `band_inputs`, `band_doubt`, `band_interval`, `named_laws`, `stiffness`, `cross_checks`, `of_bands`, `worn_weight`:
  what their springs are, how sure, whether that agrees, whether it is theirs at all, and what is worn beside them
- `evaluate`, `result`: the recipe and its answer
"""
