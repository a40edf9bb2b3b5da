"""What the model of the device lacks.

- `workflow`: the steps, one wear after the other
- `baseline`: where they begin; `uncovered_joints`: joints that no declared band crosses
- `laws`: named one after the other, by `score`, `judge`, `extra_band`; `finding`: as the report has them
- `refuted`: names that are taken back, as what is there follows another law
- `nominal`: values that are not as stated
- `left_over`: what stands above the noise; `declared`: as far as declared doubts let it
"""
