*** Settings ***
Documentation    A servo and two steppers, tested as somebody at the bench would test them.
Library          hil.robot    bench.yaml    kind=${KIND}


*** Variables ***
${KIND}          virtual


*** Test Cases ***
The Servo Says Its Angle
    Type                 m1    p
    Line Should Come     m1    Angle: 6.28, raw encoder: 286    within=200 ms

The Servo Goes Where It Is Sent
    Do Verb              m1    enable
    Do Verb              m1    move_abs    position_deg=90
    Axis Should Reach    m1    90    within=5 s    tolerance=0.1
    Pass Time            500 ms
    Field Should Be      m1    position_deg    90    tolerance=0.1

A Jammed Shaft Does Not Turn
    Do Verb              m1    enable
    ${fault} =           Inject Fault    m1    shaft_jam
    Do Verb              m1    move_abs    position_deg=90
    Pass Time            1 s
    Field Should Be      m1    position_deg    6.3    tolerance=5
    Clear Fault          ${fault}
    Axis Should Reach    m1    90    within=5 s

The Servo Forgets Nothing Without Power
    Open Port            m1
    Power Cycle          m1
    Line Should Come     m1    Mechaduino 0.X    within=5 s
    Type                 m1    p
    Line Should Come     m1    raw encoder: \\d+    within=5 s    regexp=True

The Stepper Has A Prompt
    Type                 s1    v\r
    Text Should Come     s1    SAC>
