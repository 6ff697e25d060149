rtl/gen/motion_regmap_pkg.sv
rtl/motion/pulse_generator.sv
rtl/motion/step_output.sv
rtl/motion/motion_axis.sv
rtl/motion/velocity_control.sv
rtl/motion/profile_memory.sv
rtl/motion/motion_front_end.sv
