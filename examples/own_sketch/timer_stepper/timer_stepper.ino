/* Two turns there and back by the class beside it, with a line each 100 ms while the motor moves. */

#include "TimerStepper.h"

TimerStepper stepper(6, 7);
const long THERE = 3200;

void go(long target) {
  stepper.moveTo(target);
  for (unsigned long next = millis(); stepper.isMoving();) {
    if ((long)(millis() - next) < 0) continue;
    next += 100;
    Serial.print(stepper.position());
    Serial.print(' ');
    Serial.println(stepper.speed(), 0);
  }
  Serial.print("at ");
  Serial.println(stepper.position());
}

void setup() {
  Serial.begin(115200);
  stepper.begin();
  stepper.setAcceleration(8000);
  stepper.setMaxSpeed(4000);
}

void loop() {
  go(THERE);
  delay(500);
  go(0);
  delay(500);
}
