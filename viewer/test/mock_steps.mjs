/** What the mock session asks for in a calibration, kind by kind. */
export const STEPS = {
  short: [
    { step: "neutral", seconds: 3, prompt: "Look straight ahead, lips closed, face at rest. Hold still." },
    { step: "nod", seconds: 4.5, prompt: "Keep your face at rest and nod slowly: down first, then up." },
    { step: "shake", seconds: 4.5, prompt: "Face at rest. Shake your head slowly, left and right." },
  ],
  full: [
    { step: "anchor", seconds: 3, prompt: "Smile as wide as you can.", target: { mouthSmile_L: 1, mouthSmile_R: 1, cheekSquint_L: 0.5, cheekSquint_R: 0.5 } },
    { step: "anchor", seconds: 3, prompt: "Open your mouth wide.", target: { jawOpen: 0.9, mouthLowerDown_L: 0.2, mouthLowerDown_R: 0.2 } },
    { step: "anchor", seconds: 3, prompt: "Raise your brows.", target: { browInnerUp_L: 1, browInnerUp_R: 1, browOuterUp_L: 1, browOuterUp_R: 1, eyeWide_L: 0.4, eyeWide_R: 0.4 } },
    { step: "anchor", seconds: 3, prompt: "Pucker your lips, as for a kiss.", target: { mouthPucker: 1, mouthFunnel: 0.2 } },
    { step: "anchor", seconds: 3, prompt: "Wrinkle your nose.", target: { noseSneer_L: 1, noseSneer_R: 1, mouthUpperUp_L: 0.5, mouthUpperUp_R: 0.5, browDown_L: 0.5, browDown_R: 0.5 } },
  ],
  gaze: [
    { step: "gaze", seconds: 2.7, prompt: "Keep your head still and look straight ahead", look: { yaw_deg: 0, pitch_deg: 0 } },
    { step: "gaze", seconds: 2.7, prompt: "Keep your head still and look 15 degrees to the left", look: { yaw_deg: 15, pitch_deg: 0 } },
    { step: "gaze", seconds: 2.7, prompt: "Keep your head still and look 15 degrees to the right", look: { yaw_deg: -15, pitch_deg: 0 } },
    { step: "gaze", seconds: 2.7, prompt: "Keep your head still and look 10 degrees up", look: { yaw_deg: 0, pitch_deg: 10 } },
    { step: "gaze", seconds: 2.7, prompt: "Keep your head still and look 10 degrees down", look: { yaw_deg: 0, pitch_deg: -10 } },
  ],
};
