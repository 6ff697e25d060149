rtl/fpu/fp_pkg.sv
rtl/fpu/fp_sincos_rom.sv
rtl/fpu/fp_round.sv
rtl/fpu/fp_sincos.sv
