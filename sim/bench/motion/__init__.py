# SPDX-License-Identifier: Apache-2.0
"""The motion front-end as a whole: `show` is `microtick motion`, `goals` what it is to reach.

`step_stream` makes records for five axes of any path, `sizes` keeps area and clock.
"""
