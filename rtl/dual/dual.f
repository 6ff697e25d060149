rtl/gen/dual_regmap_pkg.sv
rtl/dual/period_timer.sv
rtl/dual/set_point_buffer.sv
rtl/dual/period_sequencer.sv
rtl/dual/period_statistics.sv
rtl/dual/core_bus.sv
rtl/dual/dual_host.sv
rtl/dual/dual_asip.sv
