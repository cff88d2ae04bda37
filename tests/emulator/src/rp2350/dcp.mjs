/** A stand-in until the model is there. */
export class Dcp {}
