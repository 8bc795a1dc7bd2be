*** Settings ***
Documentation    home.py at a slide, tested as somebody at the slide would test it.
Library          hil.robot    ${BENCH}    kind=${KIND}


*** Variables ***
${BENCH}         bench.yaml
${KIND}          virtual


*** Test Cases ***
The Slide Goes Home And To Its Places
    Start Program          home.py    s1    400    -20
    Program Should Say     at 400    within=20 s
    Program Should Say     at -20    within=20 s
    Program Should End     code=0

Without The Switch The Motor Is Stopped
    Start Program          home.py    s1    --home-within    0.2
    Program Should Say     the switch did not come within 0.2 s    within=20 s
    Program Should End     code=1

The Slide Stands Where The Program Says
    Start Program          home.py    s1    400
    Program Should End     code=0    within=30 s
    Field Should Be        s1    position_deg    720    tolerance=5

A Cable That Comes Out Is Told
    Start Program          home.py    s1
    Pass Time              500 ms
    Inject Fault           s1    host_close
    Program Should Say     no answer to 'vd'    within=20 s
    Program Should End     code=1

