rtl/gen/absolute_regmap_pkg.sv
rtl/drive/absolute_registers.sv
rtl/drive/biss_master.sv
rtl/drive/biss_port.sv
