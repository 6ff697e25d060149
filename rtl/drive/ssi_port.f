rtl/gen/absolute_regmap_pkg.sv
rtl/drive/absolute_registers.sv
rtl/drive/ssi_master.sv
rtl/drive/ssi_port.sv
