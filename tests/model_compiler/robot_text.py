# SPDX-License-Identifier: Apache-2.0
"""A URDF with everything that the reader of robots uses: followers, transmission, fixed links."""

ARM = """\
<?xml version="1.0"?>
<robot name="arm">
  <link name="base"/>
  <link name="upper">
    <inertial>
      <origin xyz="0.1 0.02 -0.03" rpy="0.1 0.2 0.3"/>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0.003" ixz="0.001" iyy="0.03" iyz="-0.002" izz="0.025"/>
    </inertial>
    <visual><geometry><box size="1 1 1"/></geometry></visual>
  </link>
  <link name="fore">
    <inertial>
      <origin xyz="0.05 0 0.1"/>
      <mass value="1.5"/>
      <inertia ixx="0.01" ixy="0" ixz="0.001" iyy="0.012" iyz="0" izz="0.006"/>
    </inertial>
  </link>
  <link name="ram">
    <inertial>
      <mass value="0.8"/>
      <inertia ixx="0.002" ixy="0" ixz="0" iyy="0.002" iyz="0" izz="0.001"/>
    </inertial>
  </link>
  <link name="claw">
    <inertial>
      <origin xyz="0.04 0.01 0"/>
      <mass value="0.4"/>
      <inertia ixx="0.001" ixy="0" ixz="0" iyy="0.001" iyz="0" izz="0.001"/>
    </inertial>
  </link>
  <link name="tool">
    <inertial>
      <origin xyz="0 0.03 0.02"/>
      <mass value="0.3"/>
      <inertia ixx="0.0004" ixy="0" ixz="0" iyy="0.0004" iyz="0" izz="0.0002"/>
    </inertial>
  </link>
  <joint name="turret" type="continuous">
    <origin xyz="0.3 0.05 0.02" rpy="0.4 -1.2 0.3"/>
    <parent link="upper"/>
    <child link="fore"/>
    <axis xyz="0 0.6 0.8"/>
    <limit effort="20" velocity="4"/>
    <dynamics damping="0.3" friction="0.2"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <origin xyz="0 0.1 0.4" rpy="0.2 0.5 -0.3"/>
    <parent link="base"/>
    <child link="upper"/>
    <axis xyz="0 1 0"/>
    <limit lower="-2.5" upper="2" effort="90" velocity="3"/>
    <dynamics damping="0.5" friction="0.4"/>
  </joint>
  <joint name="slide" type="prismatic">
    <origin xyz="0 0 0.2" rpy="0.1 0.2 0"/>
    <parent link="fore"/>
    <child link="ram"/>
    <axis xyz="1 0 0"/>
    <limit lower="0" upper="0.4" effort="60" velocity="1"/>
  </joint>
  <joint name="finger" type="revolute">
    <origin xyz="0.1 0 0" rpy="0 0.3 0.2"/>
    <parent link="ram"/>
    <child link="claw"/>
    <axis xyz="0 0 1"/>
    <limit lower="-20" upper="20" effort="5" velocity="4"/>
    <mimic joint="turret" multiplier="-0.5" offset="0.3"/>
  </joint>
  <joint name="mount" type="fixed">
    <origin xyz="0.08 0 0.01" rpy="0.5 0.1 0"/>
    <parent link="claw"/>
    <child link="tool"/>
  </joint>
  <transmission name="drive">
    <type>transmission_interface/SimpleTransmission</type>
    <joint name="shoulder"><hardwareInterface>effort</hardwareInterface></joint>
    <actuator name="motor">
      <mechanicalReduction>50</mechanicalReduction>
      <rotorInertia>0.0001</rotorInertia>
    </actuator>
  </transmission>
  <gazebo reference="tool"/>
</robot>
"""
